#!/usr/bin/env bash
# Write the lock files again, with every package's hashes: pip install uv, then requirements/lock.sh. `--upgrade` takes newer versions.
set -euo pipefail
cd "$(dirname "$0")"
lock() { # FILE OPTIONS...: one lock file for every platform and every Python from 3.11
    uv pip compile --quiet --universal --generate-hashes --no-emit-index-url --no-annotate --python-version 3.11 --constraint same_everywhere.in \
        --custom-compile-command "requirements/lock.sh" "${@:2}" --output-file "$1"
}
lock develop.txt ../pyproject.toml build.in --extra test --extra docs --extra bench "$@"
lock core.txt ../pyproject.toml build.in --constraint develop.txt
lock lowest.txt ../pyproject.toml build.in --extra test --resolution lowest-direct
lock uv.txt uv.in
lock audit.txt audit.in "$@"
lock release.txt build.in release.in "$@"
