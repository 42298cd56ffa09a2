"""Tables as LaTeX: columns, rules, escapes; LaTeX itself sets them where it is installed."""

import shutil
import subprocess

import pytest

from tuner.text.latex import latex_text
from tuner.text.tables import Table

HOSTILE = '\\input{secret} 50 % of $x_1$ & #2 {~^} "a" <b> |c|'
TABLE = Table(
    "Gains\nof a run", ("gain [s⁻²]", "value", "note"), [("[k_1]", "−1.5 × 10⁻³", HOSTILE)], ("gain [s⁻²]", "note")
)


def test_a_table_has_rules_and_a_column_each():
    lines = TABLE.latex.splitlines()
    assert lines[0] == "% Gains of a run; needs \\usepackage{booktabs}"
    assert lines[1:4] == [r"\begin{tabular}{lrl}", r"\toprule", r"gain [s$^{-2}$] & value & note \\"]
    assert lines[4] == r"\midrule" and lines[-2:] == [r"\bottomrule", r"\end{tabular}"]
    # A bracket behind the end of a row would be an argument of it.
    assert lines[5].startswith("{}[k\\_1] & $-$1.5 $\\times$ 10$^{-3}$ & ")


def test_no_letter_of_a_text_steers_latex():
    text = latex_text(HOSTILE)
    assert text.startswith(
        r"\textbackslash{}input\{secret\} 50 \% of \$x\_1\$ \& \#2 \{\textasciitilde{}\textasciicircum{}\}"
    )
    assert text.endswith("''a'' $<$b$>$ $|$c$|$")


def test_powers_of_units_are_raised():
    assert latex_text("rad^(1/2) s^(-3/2)") == "rad$^{1/2}$ s$^{-3/2}$"
    assert latex_text("m s^-2, °²") == "m s$^{-2}$, $^{\\circ}$$^{2}$"


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_latex_sets_it(tmp_path):
    page = f"\\documentclass{{article}}\\usepackage{{booktabs}}\\begin{{document}}\n{TABLE.latex}\n\\end{{document}}\n"
    (tmp_path / "page.tex").write_text(page, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-1000:]
