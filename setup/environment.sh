# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2034,SC2154
# Finds or installs what PSANE runs on: ROS 2 from apt where it is sourced, else from wheels in a
# CPython 3.11 environment that uv makes from requirements.lock. Sourced by ./psane.

choose_ros() {
  ros=${PSANE_ROS:-}
  if [[ -z $ros ]]; then
    ros=wheels
    # In `./psane shell` ROS_DISTRO is our own doing.
    if [[ ${ROS_DISTRO:-} == jazzy && ${VIRTUAL_ENV:-} != "$venv" ]]; then
      if /usr/bin/python3 -c 'import rclpy' 2>/dev/null; then ros=apt
      else say "ROS 2 jazzy is sourced, but /usr/bin/python3 cannot import rclpy: using wheels"; fi
    fi
  fi
  case $ros in
    apt) python=/usr/bin/python3 ;;
    wheels) python="$venv/bin/python"; use_wheels ;;
    *) fail "PSANE_ROS = '$ros', expected apt or wheels" ;;
  esac
}

# Nothing of another ROS or Python may leak into the environment of the wheels.
use_wheels() {
  local name kept='' part
  for name in $(compgen -e ROS_) PYTHONPATH PYTHONHOME COLCON_PREFIX_PATH; do
    case $name in ROS_DOMAIN_ID|ROS_AUTOMATIC_DISCOVERY_RANGE|ROS_STATIC_PEERS|ROS_LOG_DIR|ROS_HOME) ;;
      *) unset "$name" ;;
    esac
  done
  while IFS= read -r -d : part; do
    [[ -z $part || $part == /opt/ros/* ]] || kept+="${kept:+:}$part"
  done <<<"${LD_LIBRARY_PATH:-}:"
  if [[ -n $kept ]]; then export LD_LIBRARY_PATH=$kept; else unset LD_LIBRARY_PATH; fi
  export VIRTUAL_ENV=$venv PATH="$venv/bin:$PATH" ROS_DISTRO=jazzy ROS_VERSION=2
  export AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv RMW_IMPLEMENTATION=rmw_fastrtps_cpp
}

# --- the Python environment -----------------------------------------------------------------------

find_uv() {
  local candidate
  for candidate in "$(command -v uv || true)" "${HOME:-}/.local/bin/uv" "$state/uv/bin/uv"; do
    if [[ -n $candidate ]] && "$candidate" --version >/dev/null 2>&1; then
      uv=$candidate
      return
    fi
  done
  return 1
}

install_uv() {
  python3 -c 'import venv, ensurepip' 2>/dev/null ||
    apt_install 'python3 with venv is needed to fetch uv' python3 python3-venv
  step 'making a place for uv (.psane/uv)' uv-venv python3 -m venv --clear "$state/uv"
  step 'fetching uv' uv-install "$state/uv/bin/python" -m pip install uv
  find_uv || fail "uv was installed into $state/uv, but it does not run"
}

# A CPython 3.11 that can compile: the generated messages need its headers. The distribution's comes
# first: it is built with a profile, one from a version manager often is not, and runs slower.
find_python() {
  local candidate
  for candidate in /usr/bin/python3.11 "$(command -v python3.11 || true)" \
      "$("$uv" python find --system --no-project 3.11 2>/dev/null || true)"; do
    if [[ -n $candidate ]] && "$candidate" -c 'if True:
        import os, sys, sysconfig
        header = os.path.join(sysconfig.get_path("include"), "Python.h")
        sys.exit(sys.version_info[:2] != (3, 11) or not os.path.exists(header))' 2>/dev/null; then
      base=$candidate
      return
    fi
  done
  return 1
}

install_python() {
  attempt 'fetching CPython 3.11 with uv' python "$uv" python install --managed-python 3.11 || true
  local managed
  managed=$("$uv" python find --managed-python --no-project 3.11 2>/dev/null || true)
  if [[ -n $managed ]]; then base=$managed; return; fi
  apt_install 'CPython 3.11 with its headers is needed' python3.11 python3.11-venv python3.11-dev
  find_python || fail 'CPython 3.11 was installed, but it does not run or has no headers'
}

venv_is_current() {
  [[ -x $venv/bin/python && -f $venv/.psane-lock ]] &&
    { echo "$root"; cat "$root/requirements.lock"; } | cmp -s - "$venv/.psane-lock" &&
    "$venv/bin/python" -c '' 2>/dev/null
}

# Made anew whenever the lock file changes: the wheels of ROS bring packages that the lock does not
# name, and a sync over them would take those away. From uv's cache it takes seconds.
make_venv() {
  find_uv || install_uv
  find_python || install_python
  rm -rf "$venv"
  step 'making a Python 3.11 environment (.venv)' venv "$uv" venv --python "$base" "$venv"
  step 'installing what requirements.lock names' sync "$uv" pip sync --require-hashes \
    --python "$venv/bin/python" "$root/requirements.lock"
  { echo "$root"; cat "$root/requirements.lock"; } >"$venv/.psane-lock"
}

check_apt_python() {
  command -v colcon >/dev/null ||
    fail 'colcon is missing; type:  sudo apt-get install -y python3-colcon-common-extensions'
  "$python" - <<'PYTHON' >&2 || exit 1
import importlib.util
import re
import sys
from importlib.metadata import version

apt = {'numpy': 'numpy', 'scipy': 'scipy', 'sklearn': 'sklearn', 'cv2': 'opencv',
       'matplotlib': 'matplotlib', 'yaml': 'yaml', 'pytest': 'pytest', 'hypothesis': 'hypothesis'}
pip = {'pybullet': (3, 2), 'numba': (0, 59), 'shapely': (2, 1)}  # with the oldest that will do


def is_here(module, oldest=()):
    if importlib.util.find_spec(module) is None:
        return False
    return not oldest or tuple(map(int, re.findall(r'\d+', version(module))[:2])) >= oldest


lines = {'sudo apt-get install -y': [f'python3-{apt[m]}' for m in apt if not is_here(m)],
         'pip3 install --break-system-packages': [
             f"'{m}>={oldest[0]}.{oldest[1]}'" for m, oldest in pip.items()
             if not is_here(m, oldest)]}
if any(lines.values()):
    print(f'psane: {sys.executable} lacks Python packages; type:')
    for command, names in lines.items():
        if names:
            print(' ', command, *names)
    sys.exit(1)
PYTHON
}
