#!/usr/bin/env bash
#SBATCH --job-name=forefeel-generate
#SBATCH --ntasks=64
#SBATCH --cpus-per-task=1
#SBATCH --time=04:00:00
# Solves the lattice of a scene by all tasks: sbatch generate.sh SCENE.toml OUT.states. Submitted again, it resumes.
# Each task holds the coarse half of the lattice's solutions, about as much memory as one process without MPI.
set -euo pipefail
scene=${1:?scene (TOML)}; states=${2:?state file}
export OMP_NUM_THREADS=1
# With recovery, a node that is lost costs its own running work only (Open MPI 4).
mpirun --enable-recovery forefeel generate "$scene" -o "$states" --mpi --patience 60
