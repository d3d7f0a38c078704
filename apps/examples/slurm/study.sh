#!/usr/bin/env bash
#SBATCH --job-name=forefeel-study
#SBATCH --ntasks=64
#SBATCH --cpus-per-task=1
#SBATCH --time=08:00:00
# Runs the cells of a study by all tasks: sbatch study.sh STUDY.toml FOLDER. Submitted again, it resumes: finished cells
# are kept. Tasks beyond the number of cells stay idle.
set -euo pipefail
study=${1:?study (TOML)}; folder=${2:?folder of the results}
export OMP_NUM_THREADS=1
mpirun --enable-recovery forefeel study "$study" -o "$folder" --mpi --patience 60
