"""A task in the form that an algorithm can do: with continuous or with discrete actions."""

from harness.algorithm import ActionSpace, Algorithm
from harness.errors import UsageError
from harness.motion import Discrete
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry
from harness.registry.spec import PLANNED, blamed_on
from harness.robot import Robot


def task_for(algorithm: Choice, task: Choice, robot: Robot, registry: Registry) -> Choice:
    """The task as it is if the algorithm takes its actions; else, for choices among continuous ones, in discrete form.

    The discrete form is another task, with a label of its own: ``action=discrete:action=MODE``, whose choices are
    staying and one increment of one joint or axis of the mode.

    Raises:
        UsageError: The task has no form that the algorithm takes.
    """
    built: Algorithm = algorithm.build(registry, "algorithms")
    space = _space_of(task, robot, registry)
    if space in built.action_spaces:
        return task
    taken = " and ".join(sorted(built.action_spaces))
    problem = f"{algorithm.label} takes {taken} actions, the task's are {space}"
    if "discrete" not in built.action_spaces:
        raise UsageError(problem)
    return _discrete(task, problem, robot, registry)


def _discrete(task: Choice, problem: str, robot: Robot, registry: Registry) -> Choice:
    params = dict(task.params)
    if not isinstance(params.get("action"), str):
        raise UsageError(f"{problem}, and it has no parameter 'action' to choose others")
    try:
        # Text, so that what the mode's own parameters are is found out as for any user.
        form = choose(registry, "tasks", {"name": task.name, **params, "action": f"discrete:action={params['action']}"})
        if _space_of(form, robot, registry) == "discrete":
            return form
    except UsageError as error:
        raise UsageError(f"{problem}, and it has no discrete form: {error}") from error
    raise UsageError(f"{problem}, with action={dict(form.params)['action']} too")


def _space_of(task: Choice, robot: Robot, registry: Registry) -> ActionSpace:
    built = task.build(registry, "tasks")
    with blamed_on(registry.get("tasks", task.name), PLANNED):
        built.check(robot)
        return "discrete" if isinstance(built.motion(robot), Discrete) else "continuous"
