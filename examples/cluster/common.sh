# SPDX-License-Identifier: GPL-2.0-or-later
# Sourced by the jobs: what happens when Slurm says, by USR1, that the time limit is near.

# runUntilTheLimit COMMAND...: its processes write their checkpoints at the limit, and the job queues again. They are a group of their own and
# do not mind the signal before they listen to it.
runUntilTheLimit() {
	set -m
	(trap '' USR1; exec "$@") &
	run=$!
	set +m
	trap queueAgain USR1
	wait "$run"
}

queueAgain() {
	trap '' USR1
	echo "Time is nearly up: checkpoints are written and job $SLURM_JOB_ID queues again."
	local asked
	asked=$(mktemp)
	kill -USR1 -- "-$run"
	local left=${CHECKPOINT_SECONDS:-60}
	until checkpointsAreNewer "$asked" || [ $((left--)) -le 0 ]; do
		sleep 1
	done
	rm -f "$asked"
	scontrol requeue "$SLURM_JOB_ID"
	wait "$run"
}

# Each run that is under way has a checkpoint that was written after this file.
checkpointsAreNewer() {
	local file any=no
	for file in output/*.checkpoint; do
		[ -e "$file" ] && [ ! -e "${file%.checkpoint}.json" ] || continue
		[ "$file" -nt "$1" ] || return 1
		any=yes
	done
	[ $any = yes ]
}
