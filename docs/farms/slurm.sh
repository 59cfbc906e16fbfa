#!/bin/sh
# A render in shares, and their merging, by Slurm:
#
#     ./slurm.sh scene.xml image.exr 64 --passes 4096 --block 64 -m rich-vpl
#
# SCENE OUTPUT SHARES, then options of `manylight render`. The part files are in a folder beside the image, which
# all nodes see. A share that fails is rendered once more by `scontrol requeue`; the merge begins when all are there.
set -eu
scene=$1 output=$2 shares=$3
shift 3
parts=$output.parts
mkdir -p "$parts"
array=$(sbatch --parsable --requeue --array="1-$shares" --wrap \
    "manylight render '$scene' $* --shard \$SLURM_ARRAY_TASK_ID/$shares -t \$SLURM_CPUS_ON_NODE -o '$parts/'\$SLURM_ARRAY_TASK_ID.part")
sbatch --parsable --dependency="afterok:$array" --wrap "manylight merge '$parts'/*.part -o '$output'"
