# Sourced by every script of this folder: a temporary folder, environments of pinned packages, and a small FMU of our own.
# shellcheck shell=bash
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export PROBE_CALLS=$folder/calls

# pinned <package>==<version>...: python of an environment that has these packages; later calls add to it.
pinned() {
    [[ -d $folder/venv ]] || python3 -m venv "$folder/venv"
    "$folder/venv/bin/pip" install --quiet --disable-pip-version-check "$@"
    PATH=$folder/venv/bin:$PATH
}

# probe 2|3 <file.fmu> [<sed script>]: the integrator of probe.c as an FMU whose description is edited by the script.
probe() {
    local built=$folder/built-$1 platform=linux64
    [[ $1 == 2 ]] || platform=x86_64-linux
    mkdir -p "$built/binaries/$platform" "$built/resources"
    [[ -e $built/binaries/$platform/Probe.so ]] ||
        gcc -std=c99 -O1 -Wall -Wextra -Werror -shared -fPIC -o "$built/binaries/$platform/Probe.so" "$here/probe.c"
    sed "${3:-}" "$here/probe$1.xml" >"$built/modelDescription.xml"
    (cd "$built" && rm -f "$folder/$2" && python3 -m zipfile -c "$folder/$2" modelDescription.xml binaries resources)
}
