#!/usr/bin/env bash
#SBATCH --job-name=forefeel-study
#SBATCH --array=1-64
#SBATCH --cpus-per-task=1
#SBATCH --time=08:00:00
# Runs a study in parts, one a task: sbatch study.sh STUDY.toml FOLDER. Submitted again, it resumes: finished cells are
# kept. When all tasks are done, this compares the cells:
#   forefeel study --merge FOLDER/part-* -o FOLDER/all
set -euo pipefail
study=${1:?study (TOML)}; folder=${2:?folder of the results}
part=${SLURM_ARRAY_TASK_ID:?array job}
forefeel study "$study" -o "$folder/part-$part" --part "$part/$SLURM_ARRAY_TASK_COUNT" --threads 1
