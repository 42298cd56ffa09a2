"""The command that takes pictures of a report says what it cannot do. What it shows is looked at by people."""

from tests.tuner.report.screenshots import main


def test_wrong_calls_are_told(tmp_path, capsys):
    assert main([]) == 2
    assert "usage" in capsys.readouterr().err
    assert main([str(tmp_path), str(tmp_path / "out")]) == 2
    assert "there is no report.html" in capsys.readouterr().err
