# SPDX-License-Identifier: Apache-2.0
"""What the metadata of a bag says in one line."""

from pathlib import Path

import yaml

from psane_sim.bags.recording_report import LOST

BAG = 'bag'
"""Folder of the bag that a demo records, within the demo's."""


def in_short(folder: Path) -> str:
    """Return where a bag is, how much it holds and how much it lost; or that it is not whole."""
    path = folder / 'metadata.yaml'
    if not path.is_file():
        return f'{folder}: not whole, its recorder was stopped too early'
    metadata = yaml.safe_load(path.read_text(encoding='utf-8'))['rosbag2_bagfile_information']
    lost = (metadata['custom_data'] or {}).get(LOST, 'an unknown number')
    return (f'{folder}: {metadata["message_count"]} messages on '
            f'{len(metadata["topics_with_message_count"])} topics, {lost} lost')
