# SPDX-License-Identifier: Apache-2.0
"""Writes all that the paper's experiments leave: tables, figures and one page with all of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from psane_planner.presets import PRESETS
from psane_sim.paper.ablation_report import draw_study, study_table, variant_groups
from psane_sim.paper.ablations import STUDIES
from psane_sim.paper.figures import (
    Runs,
    draw_bars,
    draw_certified_over_truth,
    draw_coverage,
    draw_paths,
)
from psane_sim.paper.groups import Group, Row, grouped
from psane_sim.paper.html_report import Picture, Section, html_report
from psane_sim.paper.pipeline_picture import draw_pipeline
from psane_sim.paper.tables import as_latex, as_markdown, groups_as_csv, trials_as_csv
from psane_sim.paper.task import PaperTask, Robot, title_of
from psane_sim.runs.animation import animate
from psane_sim.runs.run_data import StoredRun
from psane_sim.terrains.catalogue import load_terrain
from psane_sim.terrains.terrain import Terrain
from psane_sim.trials.trial_folder import TrialFolder

PIPELINE_TIME = 100.0
"""The pipeline picture shows the kept moment nearest to half the run, or to this time [s]."""

PLANNER_SHOWN = ('slip_threshold', 'confidence_scale', 'certification', 'monotone',
                 'expansion_rate', 'goal_decay', 'geodesic_goal_decay', 'border_width',
                 'clearance', 'goal_tolerance')
MAP_SHOWN = ('kernel', 'lengthscale', 'slip_prior_mean', 'slip_prior_deviation', 'slip_model',
             'strength_method', 'resolution')
"""Parameters that stand on the page; all of them are in each row."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """What was run.

    Parameters
    ----------
    robot : Robot
    preset : str
    tasks : sequence of PaperTask
    trials : int
        Of each task and strategy.
    """

    robot: Robot
    preset: str
    tasks: Sequence[PaperTask]
    trials: int

    @property
    def title(self) -> str:
        """Heading of the page."""
        return (f"The paper's experiments: {self.robot.value} robot, preset {self.preset}, "
                f'{self.trials} trial{"s" if self.trials > 1 else ""} of each')


class PaperReport:
    """Tables and figures of one folder.

    Parameters
    ----------
    folder : TrialFolder
    experiment : Experiment
    rows : mapping of str to dict
        Rows of the main experiment by name.
    ablations : mapping of str to dict
        Rows of the ablations by name; empty if they were not run.
    """

    def __init__(self, folder: TrialFolder, experiment: Experiment, rows: Mapping[str, Row],
                 ablations: Mapping[str, Row]) -> None:
        self._folder = folder
        self._out = folder.path
        self._experiment = experiment
        self._rows = rows
        self._ablations = ablations
        self._groups = grouped(list(rows.values()))
        self._runs: Runs = lru_cache(maxsize=64)(folder.run)
        self._threshold = PRESETS[experiment.preset].planner.slip_threshold

    def write(self) -> None:
        """Write everything into the folder."""
        table = as_markdown(self._groups)
        (self._out / 'table.md').write_text(table)
        (self._out / 'table.tex').write_text(as_latex(self._groups))
        (self._out / 'table.csv').write_text(groups_as_csv(self._groups))
        every = [*self._rows.values(), *self._ablations.values()]
        (self._out / 'trials.csv').write_text(trials_as_csv(every))
        sections = [Section('Results', table, [self._bars()])]
        there = {group.task for group in self._groups}
        sections += [self._task_section(task) for task in self._experiment.tasks
                     if task.name in there]
        sections += self._animation()
        if self._ablations:
            sections.append(self._ablation_section())
        sections.append(Section('Every trial', _trial_list(list(self._rows.values()))))
        sections.append(Section('What it was run with', self._setting()))
        page = html_report(self._experiment.title, sections)
        (self._out / 'report.html').write_text(page, encoding='utf-8')

    def _setting(self) -> str:
        """Return parameters that matter most, and versions, as Markdown."""
        preset = PRESETS[self._experiment.preset]
        named = [('planner', preset.planner, PLANNER_SHOWN), ('map', preset.mapping, MAP_SHOWN)]
        lines = ['| parameter | value |', '|---|---|']
        lines += [f'| {part}: `{name}` | {getattr(configuration, name)} |'
                  for part, configuration, names in named for name in names]
        versions = {tuple(sorted(row['versions'].items())) for row in self._rows.values()}
        for version in sorted(versions):
            lines += [f'| {name} | {value} |' for name, value in version]
        work = sum(row['timing']['work_s'] for row in self._rows.values())
        return '\n'.join([*lines, '', f'All trials together: {work / 60.0:.1f} minutes of work '
                          'for one core. Every parameter of each trial is in its row.'])

    def _bars(self) -> Picture:
        path = self._out / 'bars.png'
        draw_bars(self._groups, path)
        return Picture(path, 'Means with their standard deviation over the trials; time and path '
                       'of trials that arrived. Diamonds: the paper.')

    def _task_section(self, task: PaperTask) -> Section:
        groups = [group for group in self._groups if group.task == task.name]
        terrain = load_terrain(task.terrain)
        pictures = [self._paths(task, groups, terrain)]
        if not task.has_goal:
            pictures += [self._coverage(task, groups), self._certified(task, groups, terrain)]
        pictures += self._pipeline(groups)
        return Section(title_of(task.name), _optimum_text(groups), pictures)

    def _paths(self, task: PaperTask, groups: Sequence[Group], terrain: Terrain) -> Picture:
        path = self._out / f'paths_{task.name}.png'
        draw_paths(groups, self._runs, terrain, self._threshold, path)
        return Picture(path, 'The way of the first trial (black; up to four others thin) over the '
                       'true slip; its certified ground (green); where slip exceeds the threshold '
                       '(dashed); start (green dot), end (red dot), goal (star). Above each: '
                       + ('trials with success.' if task.has_goal else 'mean coverage.'))

    def _coverage(self, task: PaperTask, groups: Sequence[Group]) -> Picture:
        path = self._out / f'coverage_{task.name}.png'
        draw_coverage(groups, self._runs, path)
        return Picture(path, 'Coverage over time: mean, and one standard deviation as a band.')

    def _certified(self, task: PaperTask, groups: Sequence[Group], terrain: Terrain) -> Picture:
        path = self._out / f'certified_{task.name}.png'
        draw_certified_over_truth(groups, self._runs, terrain, self._threshold, path)
        return Picture(path, 'What the first trial had certified at its end (black line) over the '
                       'true slip, with its coverage; magenta: certified cells that are truly '
                       'unsafe.')

    def _pipeline(self, groups: Sequence[Group]) -> list[Picture]:
        for group in groups:
            run = self._runs(group.rows[0]['name'])
            if run is None or not run.moments:
                continue
            name = group.rows[0]['name']
            wanted = min(0.5 * float(run.path[-1, 0]), PIPELINE_TIME)
            moment = min(run.moments, key=lambda kept: abs(float(kept['time']) - wanted))
            path = self._out / f'pipeline_{group.task}.png'
            draw_pipeline(run, moment, self._threshold,
                          f'{name} after {float(moment["time"]):.0f} s', path)
            return [Picture(path, f'One planning cycle of {name}. Any other instant: psane '
                            f'benchmark replay {self._out.name} {name} --at SECONDS.')]
        return []

    def _animation(self) -> list[Section]:
        """Return the moving picture of one run, where the robot has a body to be seen."""
        for row in self._rows.values():
            run: StoredRun | None = self._runs(row['name'])
            if row['robot'] != Robot.PHYSICS.value or run is None or not len(run.postures) \
                    or not row['summary']['success'] or row['summary']['goal'] is None:
                continue
            path = self._out / 'run.webp'
            if not path.is_file():
                animate(run, load_terrain(row['summary']['terrain']), self._threshold, path)
            return [Section('A run', '', [Picture(
                path, f'{row["name"]}: the hexapod on its ground (dark firm, yellow soft), and '
                'its way over the true slip.')])]
        return []

    def _ablation_section(self) -> Section:
        robot, texts, pictures = self._experiment.robot, [], []
        most = 1 + max((row['seed'] for row in self._ablations.values()), default=0)
        for study in STUDIES:
            groups = variant_groups(study, self._ablations, most, robot)
            texts.append(study_table(study, groups, robot))
            path = self._out / f'ablation_{study.name}.png'
            draw_study(study, groups, path)
            pictures.append(Picture(path, study.title))
        text = '\n'.join(texts)
        (self._out / 'ablations.md').write_text(text)
        return Section('Ablations', text, pictures)


def _optimum_text(groups: Sequence[Group]) -> str:
    """Say what a robot that knows the ground would need."""
    for group in groups:
        for row in group.rows:
            summary = row['summary']
            if summary.get('least_length_m') and summary.get('least_time_s'):
                return ('A robot that knows the ground would need '
                        f'{summary["least_length_m"]:.2f} m and {summary["least_time_s"]:.1f} s.')
    return ''


def _trial_list(rows: Sequence[Row]) -> str:
    lines = ['| trial | success | end | time [s] | path [m] | unsafe [s] | false cells | coverage '
             '| cause |', '|---' * 9 + '|']
    for row in rows:
        summary = row['summary']
        numbers = [f'{summary[name]:.{digits}f}' if summary.get(name) is not None else '-'
                   for name, digits in (('time_s', 1), ('path_m', 2), ('unsafe_time_s', 2),
                                        ('false_certified_cells', 0), ('coverage', 3))]
        lines.append(f'| {row["name"]} | {"yes" if summary["success"] else "no"} | '
                     f'{summary["reason"]} | ' + ' | '.join(numbers)
                     + f' | {summary["cause"]} |')
    return '\n'.join(lines)
