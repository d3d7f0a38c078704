#!/usr/bin/env bash
# Installs the Debian 12 packages that are missing. Safe to repeat; needs root, or sudo, only when something is missing.
#   setup.sh              packages to build and run forefeel
#   setup.sh tests        also the formatter, for the fast tests
#   setup.sh all          also what slow tests compare with (VTK, SciPy, CalculiX, FEniCSx, Open MPI, Chromium), clang,
#                         Python, the baselines of forefeel-bench, and tools to make a package: over a gigabyte
#   setup.sh bench        also the baselines of forefeel-bench
#   setup.sh sanitizers   also clang for the thread sanitizer
#   setup.sh mpi          also Open MPI for workers in other processes
#   setup.sh python       also what the Python module and its examples need
set -euo pipefail

packages=(git g++ cmake ninja-build ccache libeigen3-dev libfmt-dev libcgal-dev libboost-dev libtet1.5-dev libsqlite3-dev
          libcli11-dev libtomlplusplus-dev nlohmann-json3-dev zlib1g-dev libnifti2-dev catch2 gnuplot-nox libjs-three)
format=(clang-format-14)
bench=(libsuitesparse-dev libopenblas-dev libnanoflann-dev)
sanitizers=(clang libomp-dev)
mpi=(openmpi-bin libboost-mpi-dev libopenmpi-dev)
python=(pybind11-dev python3-dev python3-numpy python3-scipy python3-matplotlib)
references=(python3-pandas python3-vtk9 calculix-ccx python3-dolfinx chromium nodejs dpkg-dev file)
wanted=${1:-}
case "$wanted" in
  "") ;;
  tests) packages+=("${format[@]}") ;;
  all) packages+=("${format[@]}" "${bench[@]}" "${sanitizers[@]}" "${mpi[@]}" "${python[@]}" "${references[@]}") ;;
  bench) packages+=("${bench[@]}") ;;
  sanitizers) packages+=("${sanitizers[@]}") ;;
  mpi) packages+=("${mpi[@]}") ;;
  python) packages+=("${python[@]}") ;;
  *) echo "setup.sh: '$1' is unknown, expected nothing, tests, all, bench, sanitizers, mpi or python" >&2; exit 2 ;;
esac

# A tree that was configured without these packages has no targets of theirs.
after() {
  case "$wanted" in ""|tests) return 0 ;; esac
  echo "Configure the tree again, or a target may be unknown: cmake --preset release"
}

if ! command -v dpkg-query >/dev/null; then
  echo "setup.sh: this is not Debian; please install the equivalents of: ${packages[*]}" >&2
  exit 1
fi
missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [ "$status" = "install ok installed" ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || { after; exit 0; }

if [ "$(id -u)" -eq 0 ]; then
  as_root=()
elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
  as_root=(sudo)
else
  echo "setup.sh: missing packages, and no right to install them. An administrator can:" >&2
  echo "  apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi
echo "Installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
after
