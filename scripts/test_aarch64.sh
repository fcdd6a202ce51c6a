#!/usr/bin/env bash
# Cross-compiles the engine for 64-bit ARM and runs its oracle and contract tests under qemu-user: `make test-aarch64`.
#
# Needs a Debian 12 machine with g++-aarch64-linux-gnu and qemu-user. It installs nothing there: the arm64 Python and its
# packages are unpacked under build/aarch64, and the system's own package lists are not touched.
# Arguments go to pytest, in place of the tests named at the end.
set -euo pipefail
cd "$(dirname "$0")/.."
here=$PWD/build/aarch64
root=$here/root
site=$here/site-packages
venv=${VENV:-$PWD/.venv}/bin

for tool in aarch64-linux-gnu-g++ qemu-aarch64 apt-get dpkg; do
  command -v $tool >/dev/null || { echo "test-aarch64 needs $tool: apt-get install g++-aarch64-linux-gnu qemu-user (Debian 12)" >&2; exit 1; }
done

# a package manager's state of its own, for arm64 alone, in which nothing is installed
arm64_apt() {
  apt-get -qq -y -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=root -o Debug::NoLocking=1 \
    -o APT::Install-Recommends=false -o Dir::State="$here/apt" -o Dir::State::status="$here/apt/status" -o Dir::Cache="$here/apt" "$@"
}

if [ ! -x "$root/usr/bin/python3.11" ]; then
  mkdir -p "$here"/apt/{lists,archives}/partial "$root"
  : >"$here/apt/status"
  arm64_apt update
  arm64_apt --download-only install python3.11 libpython3.11-dev libstdc++6
  for package in "$here"/apt/archives/*.deb; do dpkg -x "$package" "$root"; done
fi

if [ ! -d "$site" ]; then
  platforms=(--platform manylinux2014_aarch64 --platform manylinux_2_27_aarch64 --platform manylinux_2_28_aarch64)
  "$venv/python" -m pip install --quiet --disable-pip-version-check --target "$site.part" "${platforms[@]}" --only-binary=:all: \
    --implementation cp --python-version 3.11 numpy scipy pytest hypothesis mpmath
  mv "$site.part" "$site"
fi

PATH=$venv:$PATH cmake -S . -B "$here/engine" -G Ninja -DCMAKE_TOOLCHAIN_FILE=scripts/aarch64.cmake -DROOT="$root" \
  -DPython_EXECUTABLE="$venv/python" >"$here/cmake.log" || { cat "$here/cmake.log"; exit 1; }
PATH=$venv:$PATH cmake --build "$here/engine"

# the package as an arm64 machine would have it: these sources, that engine
rm -rf "$here/package"
mkdir -p "$here/package"
cp -r src/jink "$here/package/jink"
rm -f "$here"/package/jink/_native_*.so
cp "$here"/engine/_native_*.so "$here/package/jink/"

# a Graviton 2; one thread, since emulated ones gain nothing
export PYTHONPATH=$here/package:$site PYTHONDONTWRITEBYTECODE=1 OPENBLAS_NUM_THREADS=1
# what takes some 15 minutes; tests/filters/test_native_*.py are more of the kind, and slow when emulated
tests=(tests/contract/test_contract*.py tests/filters/test_oracle_{adaptive,native}.py tests/models/test_oracle_{motion,sensor}.py)
[ $# -gt 0 ] && tests=("$@")
exec qemu-aarch64 -cpu neoverse-n1 -L "$root" "$root/usr/bin/python3.11" -m pytest -p no:cacheprovider "${tests[@]}"
