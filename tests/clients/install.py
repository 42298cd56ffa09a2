"""Install the clients that exports are checked against: programs nobody here wrote, each group in an environment of its own.

    python3 tests/clients/install.py            # all groups into .clients/, and Debian's packages where this user may

Tests ask `tests.clients` for them and skip, with the reason, what cannot be installed here.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import bootstrap

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CLIENTS = ROOT / ".clients"
DEBIAN = (
    "gcc",
    "g++",
    "make",
    "libc6-dev",
    "gcc-arm-none-eabi",
    "libnewlib-arm-none-eabi",
    "qemu-system-arm",
    "octave",
    "clang",
    "libclang-rt-14-dev",
)
PROGRAMS = ("gcc", "g++", "make", "arm-none-eabi-gcc", "qemu-system-arm", "octave", "clang")


def main() -> int:
    """Install what is missing; a group that cannot be installed is named and left out."""
    debian()
    for requirements in sorted(HERE.glob("*.txt")):
        group(requirements)
    return 0


def debian() -> None:
    """Install Debian's packages where programs are missing and this user may."""
    missing = [program for program in PROGRAMS if shutil.which(program) is None]
    if not missing:
        return
    if shutil.which("apt-get") is None or (rights := rights_to_install()) is None:
        print(f"Not here: {', '.join(missing)}; on Debian: apt-get install {' '.join(DEBIAN)}")
        return
    print(f"Installing Debian's packages for {', '.join(missing)}", flush=True)
    quiet = {"env": {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}, "stdout": subprocess.DEVNULL}
    for command in (["update", "-qq"], ["install", "-y", "-qq", "--no-install-recommends", *DEBIAN]):
        if subprocess.call([*rights, "apt-get", *command], **quiet) != 0:
            print(f"apt-get {command[0]} failed; tests that need {', '.join(missing)} will be skipped")
            return


def rights_to_install() -> list[str] | None:
    """Return the prefix of a command for root; None where this user may not, or only with a password."""
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo is None or subprocess.call([sudo, "--non-interactive", "true"], stderr=subprocess.DEVNULL) != 0:
        return None
    return [sudo, "--non-interactive", "--preserve-env=DEBIAN_FRONTEND"]


def group(requirements: Path) -> None:
    """Make the environment of one requirements file, unless it was made for this very file."""
    folder = CLIENTS / requirements.stem
    stamp = folder / "installed.txt"
    wanted = requirements.read_text()
    if stamp.exists() and stamp.read_text() == wanted:
        return
    print(f"Installing clients: {requirements.stem}", flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    python = folder / "bin" / "python"
    uv = bootstrap.find_uv() or bootstrap.bring_uv(sys.executable)
    made = bootstrap.is_done([sys.executable, "-m", "venv", *(["--without-pip"] if uv else []), str(folder)])
    if uv:
        installer = [uv, "pip", "install", "--quiet", "--python", str(python)]
    else:
        installer = [str(python), "-m", "pip", *bootstrap.PIP_INSTALL]
    if made and bootstrap.is_done([*installer, "-r", str(requirements)]):
        stamp.write_text(wanted)
    else:
        print(f"{requirements.name} could not be installed; the tests that need it will be skipped")


if __name__ == "__main__":
    sys.exit(main())
