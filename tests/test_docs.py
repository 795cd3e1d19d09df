# SPDX-License-Identifier: Apache-2.0
"""The pages in docs/ name what exists, and their formulas are those of the code."""

import math
import re
from dataclasses import fields, replace

import numpy as np
import pytest
import yaml
from felt_stances import stance
from hypothesis import given, settings
from hypothesis import strategies as st
from source_tree import PACKAGES, ROOT, modules_of

from psane_mapping.configuration import MappingConfiguration
from psane_mapping.contact import LegContact
from psane_mapping.rft import NEWTON_PER_CUBIC_METRE, flowing_forces, stress
from psane_mapping.strength import estimate_strength
from psane_sim.generated_text import PARAMETERS

PAGES = [*sorted((ROOT / 'docs').glob('*.md')), ROOT / 'README.md',
         *sorted((ROOT / 'examples').rglob('*.md'))]
GUIDES = [page for page in PAGES if page.parent.name == 'docs']
law = settings(deadline=None, derandomize=True, max_examples=40)
UNUSED = 1.0e6
"""Deviation that the pages give to a channel that was not measured [N]."""


def page_id(page):
    return str(page.relative_to(ROOT))


def test_the_pages_are_there():
    assert {'algorithms.md', 'nav2.md', 'packages.md', 'your-robot.md'} <= {
        page.name for page in GUIDES}


@pytest.mark.parametrize('page', PAGES, ids=page_id)
def test_every_link_within_the_repository_leads_somewhere(page):
    for target in re.findall(r'\]\(([^)#]+?)(?:#[^)]*)?\)', page.read_text()):
        if '://' not in target:
            assert (page.parent / target).exists(), f'{page.name} links to {target}'


@pytest.mark.parametrize('page', GUIDES, ids=page_id)
def test_the_readme_leads_to_every_page(page):
    assert f'docs/{page.name}' in (ROOT / 'README.md').read_text()


def source_text():
    kinds = ('*.py', '*.msg', '*.srv', '*.action')
    return '\n'.join(path.read_text() for kind in kinds
                     for path in (ROOT / 'src').rglob(kind))


# Nav2's names are its own; those of figures are put together, and have a test of their own.
NAMED_ELSEWHERE = ('nav2.md', 'measured.md')


@pytest.mark.parametrize('page', [page for page in GUIDES if page.name not in NAMED_ELSEWHERE],
                         ids=page_id)
def test_every_name_with_an_underscore_is_in_the_source(page):
    text, source = page.read_text(), source_text()
    spans = re.findall(r'`([^`\n]+)`', text)
    names = {name for span in spans for name in re.findall(r'\b[a-zA-Z]\w*_\w+\b', span)}
    names -= {path.stem for path in (ROOT / 'tests').glob('*.py')}
    files = {path.stem for package in PACKAGES for path in modules_of(package)}
    files |= {path.name for path in (ROOT / 'examples').iterdir()}
    packages = {*PACKAGES, 'psane_msgs'}
    symbols = {'alpha_z', 'alpha_x', 'sigma_f', 'sigma_x', 'beta_r', 'l_t', 'u_t', 'g_t', 'tau_d',
               'v_max', 'e_max', 'k_w', 'delta_goal', 'A_mn'}
    missing = {name for name in names - files - packages - symbols
               if not re.search(rf'\b{re.escape(name)}\b', source)}
    assert not missing


def test_the_package_guide_names_each_file_that_it_should_and_no_other():
    text = (ROOT / 'docs' / 'packages.md').read_text()
    named = set(re.findall(r'`((?:\w+/)*\w+\.py)`', text))
    there = {name for package in PACKAGES for path in modules_of(package)
             for name in (path.name, '/'.join(path.relative_to(ROOT / 'src').parts[1:]),
                          '/'.join(path.relative_to(ROOT / 'src').parts[2:]))}
    there |= {f'tests/{path.name}' for path in (ROOT / 'tests').glob('*.py')}
    there |= {path.name for path in (ROOT / 'tests').glob('*.py')}
    assert len(named) > 60
    assert not named - there


@pytest.mark.parametrize('page', PAGES, ids=page_id)
def test_no_page_names_a_place_of_one_machine(page):
    assert not re.findall(r'(?:^|[\s"`(])/(?:home|root|work|tmp|Users)/\S+', page.read_text())


def test_the_yaml_of_the_nav2_page_can_be_read():
    blocks = re.findall(r'```yaml\n(.*?)```', (ROOT / 'docs' / 'nav2.md').read_text(), re.S)
    assert len(blocks) == 2
    costmap = yaml.safe_load(blocks[0])['global_costmap']['global_costmap']['ros__parameters']
    assert costmap['static_layer']['map_topic'] == '/safe_map'
    assert costmap['track_unknown_space'] is True


def test_the_limits_of_the_nav2_page_are_those_of_the_controller():
    defaults = {entry.name: entry.default
                for kind in PARAMETERS['psane_reactive', 'reactive_controller']
                for entry in fields(kind)}
    blocks = re.findall(r'```yaml\n(.*?)```', (ROOT / 'docs' / 'nav2.md').read_text(), re.S)
    smoother = yaml.safe_load(blocks[1])['velocity_smoother']['ros__parameters']
    assert smoother['max_velocity'][::2] == [defaults['linear_limit'], defaults['angular_limit']]
    assert smoother['max_accel'][::2] == [defaults['linear_acceleration'],
                                          defaults['angular_acceleration']]


# --- formulas

@law
@given(tilt=st.floats(-1.5, 1.5))
def test_straight_intrusion_meets_the_stress_of_the_page(tilt):
    expected = 0.564 + 0.436 * math.cos(2.0 * tilt)
    assert stress(tilt, math.pi / 2.0)[1] == pytest.approx(expected, abs=1e-12)


@law
@given(area=st.floats(1e-4, 0.05), depth=st.floats(1e-3, 0.3))
def test_a_flat_foot_at_strength_1_feels_a_million_newton_per_cubic_metre(area, depth):
    force = flowing_forces(np.array([[0.0, 0.0, -0.1]]), np.array([[0.0, 0.0, -1.0]]),
                           np.array([area]), np.zeros(1), np.array([depth]), np.ones(1))
    assert force[0, 2] == pytest.approx(1.0e6 * area * depth, rel=1e-9)


def ball_of_rings(radius, depth):
    """Sum the stress over the lower half of a ball, ring by ring [N]."""
    angle = (np.arange(4000) + 0.5) / 4000 * math.pi / 2.0
    ring = 2.0 * math.pi * radius**2 * np.sin(angle) * (math.pi / 2.0 / 4000)
    under = np.maximum(depth - radius * (1.0 - np.cos(angle)), 0.0)
    alpha = np.array([stress(tilt, math.pi / 2.0)[1] for tilt in angle])
    return float(NEWTON_PER_CUBIC_METRE * (alpha * ring * under).sum())


def ball_of_the_page(radius, depth):
    c = 1.0 - min(depth, radius) / radius
    bracket = 0.064 * (1 - c)**2 + 0.218 * (1 - c**4) - 0.872 / 3.0 * c * (1 - c**3)
    deeper = 1.0e6 * 0.837 * math.pi * radius**2 * max(depth - radius, 0.0)
    return 1.0e6 * 2.0 * math.pi * radius**3 * bracket + deeper


@pytest.mark.parametrize('share', [0.05, 0.3, 0.7, 1.0, 1.8])
def test_a_ball_at_strength_1_feels_what_the_page_says(share):
    radius = 0.03
    rings = ball_of_rings(radius, share * radius)
    # 4000 rings, and three digits of the page's constants.
    assert ball_of_the_page(radius, share * radius) == pytest.approx(rings, rel=2e-3)


@pytest.mark.parametrize('formula', ['0.064 (1 - c)^2 + 0.218 (1 - c^4) - 0.872/3 c (1 - c^3)',
                                     '0.564 + 0.436 cos(2 beta)', '0.837 pi r^2 (z - r)'])
def test_the_formulas_tested_here_are_those_of_the_page(formula):
    assert formula in (ROOT / 'docs' / 'your-robot.md').read_text()


def flat_foot_stance(strength, area=0.004, noise=0.03, seed=1):
    """Return the record that the page describes for a flat foot."""
    rng = np.random.default_rng(seed)
    depth = 0.02 * np.sin(np.linspace(0.0, math.pi, 60))
    response = np.zeros((60, 3))
    response[:, 1] = 1.0e6 * area * np.maximum(depth, 0.0)
    measured = np.zeros((60, 3))
    deviation = np.full((60, 3), UNUSED)
    deviation[:, 1] = 1.0 + noise * strength * response[:, 1]
    measured[:, 1] = strength * response[:, 1] + deviation[:, 1] * rng.normal(size=60)
    return LegContact(leg=0, touch_down=0.0, lift_off=0.6, point=np.array([5.0, 5.0]),
                      point_deviation=0.01, depth=depth, measured=measured, response=response,
                      deviation=deviation, has_velocity=False)


@pytest.mark.parametrize('strength', [0.05, 0.3, 1.0, 3.0])
def test_the_mapper_reads_the_strength_of_ground_from_a_flat_foot(strength):
    estimate = estimate_strength(flat_foot_stance(strength), MappingConfiguration())
    away = abs(math.log(estimate.strength / strength))
    assert away < 3.0 * estimate.scatter_deviation + 0.01


@pytest.mark.parametrize('strength', [0.1, 0.3, 1.0])
def test_the_mapper_reads_the_strength_of_ground_from_hip_moments_alone(strength):
    whole = stance(strength=strength, noise=0.3, seed=2)
    columns = {}
    for name, blank in (('measured', 0.0), ('response', 0.0), ('deviation', UNUSED)):
        values = np.array(getattr(whole, name))
        values[:, :2] = blank
        columns[name] = values
    estimate = estimate_strength(replace(whole, **columns), MappingConfiguration())
    assert math.log(estimate.strength / strength) == pytest.approx(0.0, abs=0.05)
