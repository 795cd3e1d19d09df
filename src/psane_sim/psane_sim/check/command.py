# SPDX-License-Identifier: Apache-2.0
"""`psane run psane_sim check`: listen to a robot's topics and say what PSANE could not use."""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields

from psane_mapping.errors import ParameterError
from psane_mapping.parameters import declaration_of
from psane_sim.check.findings import Finding
from psane_sim.check.settings import PROFILES, CheckSettings
from psane_sim.check.topic_check import EXPECTATIONS, SENSOR_TOPICS, judge, profile_of
from psane_sim.check.topic_record import Recording

ALL_WELL, FAULTS, BAD_ARGUMENT = 0, 1, 2
"""Exit statuses."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(
        prog='psane run psane_sim check',
        description='Listen to the topics of a robot and say what is missing, stale, or in the '
        'wrong unit, frame or quality of service. Let the robot walk and turn meanwhile: '
        'most units can only be told from motion. Remap with --ros-args -r.',
        epilog='Exit status: 0 all is well, 1 there are faults, 2 a bad argument.')
    made.add_argument('--duration', type=float, default=10.0, metavar='S',
                      help='how long to listen [s on the wall] (default 10)')
    for entry in fields(CheckSettings):
        declared = declaration_of(entry)
        unit = '' if declared.unit == '-' else f' [{declared.unit}]'
        default = f'{entry.default:g}' if isinstance(entry.default, float) else entry.default
        made.add_argument(
            f'--{entry.name.replace("_", "-")}', type=type(entry.default), default=entry.default,
            choices=PROFILES if declared.choices else None,
            metavar=None if declared.choices else entry.name.split('_')[-1].upper(),
            help=f'{declared.meaning}{unit} (default {default})')
    return made


def report(recording: Recording, findings: list[Finding], settings: CheckSettings) -> str:
    """Return what was heard and found, in words."""
    profile = profile_of(recording, settings)
    lines = [f'heard for {recording.duration:.1f} s; judged as a robot that publishes '
             + ('sensors for contact_sensor' if profile == 'sensors' else 'its own contacts')]
    for name in ('/clock', *EXPECTATIONS):
        if profile == 'contacts' and name in SENSOR_TOPICS:
            continue
        record = recording.clock if name == '/clock' else recording.topic(name)
        own = [finding for finding in findings if finding.topic == name]
        if name == '/clock' and not (record.publishers or own):
            lines.append('  ok    /clock         nobody publishes it: time is wall time')
            continue
        word = 'FAULT' if any(finding.is_fault for finding in own) else 'ok   '
        is_regular = name == '/clock' or EXPECTATIONS[name].least_rate > 0.0
        pace = f', {record.rate:.0f} Hz' if is_regular and record.rate == record.rate else ''
        lines.append(f'  {word} {name:14s} {record.count} messages{pace}')
        lines += _sentences(own)
    own = [finding for finding in findings if finding.topic == 'cmd_vel']
    heard = len(recording.topic('cmd_vel').subscribers)
    lines.append(f'  {"FAULT" if own else "ok   "} {"cmd_vel":14s} {heard} listeners')
    return '\n'.join([*lines, *_sentences(own), _verdict(findings)])


def _sentences(findings: list[Finding]) -> list[str]:
    return [f'        {"-" if finding.is_fault else "note:"} {finding.sentence}'
            for finding in findings]


def _verdict(findings: list[Finding]) -> str:
    count = sum(finding.is_fault for finding in findings)
    return 'all is well' if count == 0 else f'{count} fault{"s" if count > 1 else ""}'


def main(arguments: Sequence[str] | None = None) -> None:
    """Listen, judge, report, and end the program with its exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    cut = given.index('--ros-args') if '--ros-args' in given else len(given)
    options = vars(parser().parse_args(given[:cut]))
    duration = options.pop('duration')
    try:
        settings = CheckSettings(**options)
        if not 0.5 <= duration <= 3600.0:
            raise ParameterError('duration', duration, 'a value in [0.5, 3600]', 's')
    except ParameterError as error:
        print(f'psane check: {error}', file=sys.stderr)
        sys.exit(BAD_ARGUMENT)
    # Only here, so that a bad argument is answered at once.
    from psane_sim.check.ros_topic_listener import listen
    recording = listen(duration, given[cut:])
    findings = judge(recording, settings)
    print(report(recording, findings, settings))
    sys.exit(FAULTS if any(finding.is_fault for finding in findings) else ALL_WELL)
