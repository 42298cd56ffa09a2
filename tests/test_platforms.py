"""Every locked package has a wheel on every supported version of Python and platform."""

import subprocess

import pytest

import bootstrap

PLATFORMS = ("x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "aarch64-apple-darwin", "x86_64-pc-windows-msvc")
VERSIONS = [f"3.{minor}" for minor in range(bootstrap.OLDEST[1], bootstrap.NEWEST[1] + 1)]


@pytest.mark.slow
@pytest.mark.parametrize("lock", ["core.txt", "develop.txt"])
@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize("version", VERSIONS)
def test_lock_files_resolve_to_wheels(version, platform, lock, tmp_path):
    uv = bootstrap.find_uv() or bootstrap.bring_uv(bootstrap.sys.executable)
    if uv is None:
        pytest.skip("uv is not here, and pip cannot bring it")
    place = ["--python-version", version, "--python-platform", platform, "--target", str(tmp_path)]
    locked = ["--require-hashes", "-r", str(bootstrap.ROOT / "requirements" / lock)]
    command = [uv, "pip", "install", "--dry-run", "--only-binary", ":all:", *place, *locked]
    done = subprocess.run(command, capture_output=True, text=True, env=bootstrap.environment())
    assert done.returncode == 0, done.stderr
