#!/bin/sh
# Install Macta's wheels, its own and that of the robots' software, for production into a new environment: sh examples/install_production.sh FOLDER
# Without test tools and optional engines, and without what PyBullet's wheel holds besides the physics: models and
# environments of its examples, a renderer, debugging symbols. Needs uv, and binutils to remove the symbols.
set -eu
folder=$(realpath -m "$1")
cd "$(dirname "$0")/.."

uv venv --quiet "$folder"
uv build --quiet --all-packages --wheel --out-dir "$folder/wheel"
# Copies, not links: what is removed here stays in uv's cache and in other environments.
uv pip install --quiet --python "$folder" --link-mode copy --compile-bytecode "$folder"/wheel/*.whl
rm -r "$folder/wheel"

cd "$("$folder/bin/python" -c "import sysconfig; print(sysconfig.get_path('platlib'))")"
rm -r pybullet_data pybullet_envs pybullet_examples pybullet_robots pybullet_utils eglRenderer.*.so
if command -v strip >/dev/null; then
    strip --strip-unneeded pybullet.*.so zstandard/*.so
fi
