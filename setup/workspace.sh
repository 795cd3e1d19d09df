# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154
# Builds the workspace when, and only when, something changed that a build depends on. Sourced by
# ./psane.

# What a build depends on. Python files and the contents of configurations are linked into install/,
# so a change in them needs no build.
fingerprint() {
  cd -- "$root"
  { printf '%s\n' "$ros" "$root" "$python"
    find src -path '*/config/*' -name '*.yaml' | LC_ALL=C sort
    { find cmake src/psane_msgs -type f -print0
      find src -maxdepth 2 -type f -print0
      [[ $ros == apt ]] || printf 'requirements.lock\0'
    } | LC_ALL=C sort -z | xargs -0 sha256sum
  } | sha256sum | cut -d ' ' -f 1
}

workspace_is_current() {
  [[ -f $root/install/local_setup.bash && -f $state/built ]] &&
    [[ $(<"$state/built") == "$ros $root $(fingerprint)" ]]
}

build_workspace() {
  local cmake_arguments=(-DBUILD_TESTING=OFF "-DPython3_EXECUTABLE=$python") previous='' package
  command -v c++ >/dev/null && command -v cc >/dev/null ||
    apt_install 'a C and C++ compiler is needed to build the messages' gcc g++ libc6-dev
  [[ $ros == apt ]] || cmake_arguments+=(-G Ninja
    "-DCMAKE_PROJECT_INCLUDE=$root/cmake/fix_wheel_paths.cmake")
  if [[ -f $state/built ]]; then previous=$(<"$state/built"); fi
  # Built for another place or another ROS, nothing of it can be used again.
  if [[ $previous != "$ros $root "* ]]; then
    for package in "${packages[@]}"; do rm -rf "$root/build/$package" "$root/install/$package"; done
  fi
  # From here to the end of the build only the place counts, so that a broken build is built again.
  mkdir -p "$state"
  echo "$ros $root -" >"$state/built"
  local words='building the workspace with colcon'
  [[ -d $root/build/psane_msgs ]] || words+=' (about a minute the first time)'
  cd -- "$root"
  step "$words" build colcon --log-base "$root/log" build --base-paths src --symlink-install \
    --event-handlers console_direct+ --cmake-args "${cmake_arguments[@]}"
  echo "$ros $root $(fingerprint)" >"$state/built"
}

is_ready() { { [[ $ros == apt ]] || venv_is_current; } && workspace_is_current; }

# The script that colcon wrote calls Python without quotes, so it is given a path without a blank.
load_workspace() {
  local here=$PWD
  cd -- "$root"
  set +u
  # shellcheck disable=SC1091
  COLCON_PYTHON_EXECUTABLE=${python#"$root/"} source install/local_setup.bash
  set -u
  cd -- "$here"
}

# Where numba keeps machine code: a place for each state of the compiled sources, since numba looks
# for changes in one file only, and not in the compiled functions that it calls from others. Places
# that nobody used for a day are removed.
choose_numba_cache() {
  local place="$state/numba" sources
  sources=$(cd -- "$root" && { grep -rlZ --include='*.py' -e njit src || true; } |
    LC_ALL=C sort -z | xargs -0r sha256sum | sha256sum | cut -c 1-16)
  export NUMBA_CACHE_DIR="$place/$sources"
  mkdir -p "$NUMBA_CACHE_DIR"
  touch "$NUMBA_CACHE_DIR"
  find "$place" -mindepth 1 -maxdepth 1 -type d -mmin +1440 -exec rm -rf {} +
}

# After this the environment is that of the workspace.
prepare() {
  if ! is_ready; then
    mkdir -p "$state"
    exec {lock}>"$state/lock"
    flock -n "$lock" || { say 'another start is setting up; waiting for it'; flock "$lock"; }
    if [[ $ros == apt ]]; then check_apt_python; else venv_is_current || make_venv; fi
    workspace_is_current || (build_workspace)
    exec {lock}>&-
  fi
  load_workspace
  # One thread each: the nodes are processes of their own and would only take turns.
  export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
  # A place that an outer `./psane` chose may be out of date by now.
  [[ ${NUMBA_CACHE_DIR:-$state/numba/} != "$state/numba/"* ]] || choose_numba_cache
}
