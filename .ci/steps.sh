# Sourced by the scripts beside it: names the steps of a run, and notes in target/ci/times how long each took.
times=target/ci/times
step_name=
step_begun=0

# Begins a step; with no name it only ends the one before.
step() {
    if [ -n "$step_name" ]; then
        printf '%5d s  %s\n' $((SECONDS - step_begun)) "$step_name" >>"$times"
    fi
    step_name=$* step_begun=$SECONDS
    if [ -n "$step_name" ]; then
        printf '\n== %s\n' "$step_name"
    fi
}

mkdir -p target/ci
trap step EXIT
