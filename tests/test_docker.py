# SPDX-License-Identifier: Apache-2.0
"""The image is built by the very steps that the README gives for apt."""

import re

from source_tree import ROOT


def section(text, begin, end):
    return text[text.index(begin) + len(begin):text.index(end)]


def apt_packages(text):
    """Return the packages of the first `apt-get install` in a text."""
    command = re.search(r'apt-get install -y --no-install-recommends((?:[^\n]*\\\n)*[^\n]*)', text)
    words = command.group(1).replace('\\\n', ' ').split('&&')[0].split()
    return sorted(words)


def pip_packages(text):
    return sorted(re.findall(r"'([a-z]+==[\d.]+)'", text))


def test_readme_and_dockerfile_install_the_same():
    readme = section((ROOT / 'README.md').read_text(), '<!-- apt:begin -->', '<!-- apt:end -->')
    dockerfile = (ROOT / 'docker' / 'Dockerfile').read_text()
    assert len(apt_packages(readme)) > 5
    assert apt_packages(readme) == apt_packages(dockerfile)
    assert len(pip_packages(readme)) == 3
    assert pip_packages(readme) == pip_packages(dockerfile)
    for step in ('source /opt/ros/jazzy/setup.bash', './psane build'):
        assert step in readme
        assert step in dockerfile
