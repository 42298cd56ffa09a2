"""The plant of one's own and its study from the page of the documentation."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[3] / "docs/own_plant.md").read_text(encoding="utf-8")
PLANT, STUDY = (re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)[0] for kind in ("python", "toml"))


def write_motor(folder: Path, study: str = STUDY) -> Path:
    """Write both files into a folder and return the path of the study."""
    (folder / "motor.py").write_text(PLANT, encoding="utf-8")
    (folder / "motor.toml").write_text(study, encoding="utf-8")
    return folder / "motor.toml"
