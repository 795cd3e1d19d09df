# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2154
# Says what is being done, keeps its log, and installs Debian packages. Sourced by ./psane.

say() { printf 'psane: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

# attempt WORDS LOG COMMAND...: run a command with its output in a log, say how long it took.
attempt() {
  local words=$1 log="$state/logs/$2.log" begin=$SECONDS
  shift 2
  mkdir -p "$state/logs"
  say "$words"
  "$@" >"$log" 2>&1 </dev/null || return 1
  say "  done in $((SECONDS - begin)) s"
}

# step: the same, and a failure ends the script with the end of the log.
step() {
  attempt "$@" && return
  say "that failed; the end of $state/logs/$2.log:"
  tail -n 30 "$state/logs/$2.log" >&2
  exit 1
}

# apt_install REASON PACKAGE...: install as root or with sudo, or say what to type.
apt_install() {
  local reason=$1 sudo=()
  shift
  command -v apt-get >/dev/null || fail "$reason. Install what Debian calls: $*"
  if [[ $EUID -ne 0 ]]; then
    sudo=(sudo)
    command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [[ -t 0 ]]; } || fail \
      "$reason. Have an administrator type:  apt-get update && apt-get install -y $*"
  fi
  attempt "$reason: installing $*" apt-update "${sudo[@]}" apt-get update || true
  step "installing with apt" apt-install "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y --no-install-recommends "$@"
}
