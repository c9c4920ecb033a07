"""What cannot be done is said in one line, before anything is written. Tables that need a folder stand beside it."""

import shutil

import pytest

from tests.cli.test_eta import BASE, HEADER, K2
from tests.cli.test_logs import write_monitor
from tests.record.dataset.written import episode, write_lerobot, write_minari
from tests.results.recordings.conftest import record

RUN = "run --sim ideal --algo wander"
REFUSED = {
    "run": {
        "": "harness run FILE.toml",
        "--algo wander": "names no sim",
        "--sim ideall --algo wander": "Did you mean 'ideal'?",
        "--sim ideal --algo wonder": "Did you mean 'wander'?",
        "--sim ideal --algo dense": "'dense' is of another kind: reward. No algorithm 'dense'. There is",
        "--sim ideal --algo wander --plugin file.py other.py": "--plugin takes one file: repeat it, or quote a pattern",
        "--sim ideal --algo wander --reward file.py": "The file here needs --plugin file.py",
        "missing.toml": "No experiment file 'missing.toml'",
        "--simulator ideal": "No such option",
    },
    RUN: {
        "--reward arp:k2": "write name or name:key=value",
        "--reward arp:k3=1": "There is: k1, k2",
        "--reward arp:k2=much": "valid number",
        "--reward arp:k2=-1": "greater than 0",
        "--reward arp,dense --baseline none": "baseline=none trains one reward alone, and 2 are named",
        "--steps 0": "greater than 0",
        "--steps -3": "greater than 0",
        "--steps many": "valid integer",
        "--seeds 0": "greater than 0",
        "--seeds a,b": "--seeds a,b",
        "--evaluate-every -1": "greater than or equal to 0",
        "--jobs 0": "jobs=0: must be at least 1",
        "--robot fd10": "Did you mean 'fd100'?",
        "--task fd100-reach:epsilon=0": "greater than 0",
        "--task fd100-reach:epsilon=3": "covers the targets",
        "--task fd100-reach:target_center=9x9x9": "reaches next to no target",
        "--executor cloud": "No executor 'cloud'",
        "--executor here:nodes=2": "Executor 'here' has no parameter 'nodes'",
        "--tracker wanb": "No tracker 'wanb'",
        "--tracker clumsy:mood=bad": "'clumsy:mood=bad' cannot be used: not now",
        "--metric wrok": "Did you mean 'work'",
        "--only ''": "--only: no cell of this experiment has ''",
        "--out file/deeper": "--out 'file/deeper' cannot be written",
        "--out there": "holds something else",
        "--fail-on hurtz": "Did you mean 'hurts'?",
        "--fail-on hurts,failing": "--fail-on failing: only --screen looks for that",
        "--until decided --looks 6,4": "have to increase",
        "--until decided --looks a,b": "--looks a,b: give numbers of seeds that increase",
        "--until decided --margin 0": "margin=0.0: Input should be greater than 0",
        "--until decided --seeds 5": "finds the number of seeds itself",
        "--until sunset": "'sunset' is not one of 'decided'",
        "--looks 2,4": "looks go with until",
        "--budget soon": "--budget soon: give a time, such as 90s, 30m, 2h or 1d",
        "--budget -1h": "--budget -1h: give a time",
        "--budget nanh": "--budget nanh: give a time",
    },
    "choose --sim ideal --algo wander": {
        "": "which rewards?",
        "--plugin 'nothing/*.py'": "No Python file matches 'nothing/*.py'",
        "--reward nothing": "No reward 'nothing'",
        "--reward dense": "one candidate leaves nothing to choose",
    },
    "audit": {
        "": "Missing option '--reward'; or name an environment, or a folder",
        "--reward baselin": "Did you mean 'baseline'?",
        "--reward arp:k2=0": "k2='0': Input should be greater than 0",
        "--reward arp --measure success_rate": "--measure does not go with a task, only with an environment",
        "--task fd100-reach:action=movel --reward dense --budget 0": "The scripted policies of an audit move joints",
        "--replay none.json": "--replay none.json: there is no such file",
        "--replay none.json --reward arp": "--reward does not go with a certificate, only with a task",
        "--replay none.json --fail-on failing": "--fail-on does not go with a certificate",
        "fd100-reach --replay none.json": "--replay does not go with a task, only with a certificate: leave it out",
        "--replay none.json --budget 9": "--budget does not go with a certificate",
        "minari:none": "No Minari data set at 'none'",
        "minari:none --fail-on hurts": "No answer 'hurts'. There is: against, cannot-tell, failing, loitering.",
        "lerobot:none": "No LeRobot data set at 'none'",
        "gymnasium:id=Pendulum-v1 --sim ideal": "--sim does not go with an environment",
        "nowhere": "There is no file or folder 'nowhere'. No task 'nowhere'.",
        "--random random": "--random does not go with a task, only with an experiment or a folder",
    },
    "audit --reward arp": {
        "--against arpp": "Did you mean 'arp'?",
        "--sim idea": "Did you mean 'ideal'?",
        "--task reach": "No task 'reach'",
        "--robot fd10": "Did you mean 'fd100'?",
        "--episodes 0": "--episodes 0: must be at least 1",
        "--gamma 1.5": "--gamma 1.5: must be above 0",
        "--gamma nan": "--gamma nan: must be above 0 and at most 1",
        "--task fd100-reach:target_center=9x9x9": "reaches next to no target",
        "--budget 0 --out x": "--out needs a search: leave out --budget 0",
        "--out file": "--out 'file' cannot be written",
        "--html none/page.html": "--html 'none/page.html': name a file in a folder that exists",
        "--success done": "--success does not go with a task, only with an environment or a data set",
        "--budget -1": "--budget -1: must be at least 0",
        "--starts 0": "--starts 0: must be at least 1",
        "--as table": "--as does not go with a task, only with logs of trainings",
        "--partial": "--partial does not go with a task, only with a data set",
        "--places end_effector=0:3,target=3:6": "--places does not go with a task, only with a data set",
    },
    "check": {
        "": "nothing to check: type harness check NAME",
        "arpp": "Did you mean 'arp'?",
        "arp --kind rewrd": "Did you mean 'reward'?",
        "arp --kind metric": "No metric 'arp'",
        "arp:k9=1": "has no parameter 'k9'",
        "arp --robot fd100": "reward 'arp' is checked without a robot",
    },
    "describe": {
        "fd100-reech": "Did you mean 'fd100-reach'?",
        "rewadrs": "Did you mean 'rewards'?",
        "gymnasium:pays=reward_ctrl": "id has to be given",
    },
    "new-plugin": {
        "exporter zz": "No kind of plugin 'exporter'",
        "reward Arp": "must be words of lower-case letters",
        "reward arp": "taken: there is a reward of 'rewards'",
        "reward rewards": "The name 'rewards' is taken: there is a plugin",
        "command status": "taken: it is a command of the harness",
        "command export": "taken: there is a command of 'commands'",
        "metric zz-metric --into mine": "'mine' is no folder: make it first",
    },
    "parity": {
        "--sim ideall": "Did you mean 'ideal'?",
        "--sim ideal,ideal": "--sim names 'ideal' twice",
        "--sim ideal --reference hi": "No simulator 'hi'",
        "--sim ideal,stuck --robot fd10": "Did you mean 'fd100'?",
        "--steps 0": "--steps 0: must be at least 1",
        "--episodes 0": "--episodes 0: must be at least 1",
        "--seed -1": "--seed -1: must be at least 0",
        "--period 0": "--period 0: must be above 0",
        "--period nan": "--period nan: must be above 0",
        "--sim ideal,stuck --html no/p.html --steps 2 --episodes 1": "'no/p.html' cannot be written",
    },
    "eta": {
        "": "Missing option '--baseline'; or name a folder of trainings",
        "nowhere": "No folder or file 'nowhere'",
        "minari:a/b-v0": "is a data set, which holds no trainings to compare: harness audit minari:a/b-v0",
    },
    "score": {
        "'nowhere*.csv' --reward arp": "No file matches 'nowhere*.csv'",
        "their --reward arp": "No folder or file 'their'. Did you mean 'there'?",
        "m.csv --places end_effector=0:3,target=3:6": "--places does not go with files, only with a data set",
    },
    "demo": {"--out there": "--out 'there' holds something else than an experiment: name a new or empty folder"},
    "merge": {"missing --out all": "No folder 'missing'"},
    "report": {
        "there": "'there' is no experiment, and holds no recorded training",
        "their": "No folder or file 'their'. Did you mean 'there'?",
        "thesis.txt": "No folder or file 'thesis.txt'. Did you mean 'there/thesis.txt'?",
    },
    "status": {"nowhere": "No folder 'nowhere'"},
    "transfer": {"nowhere": "No folder or file 'nowhere'"},
    "verify": {"there": "is no experiment", "there --repair": "is no experiment"},
    "watch": {"there --no-browser": "'there' is no experiment: it holds no plan.json"},
}
"""By what the lines have in common: the rest of each, and what is said of it."""


@pytest.mark.parametrize("begun", REFUSED)
def test_what_cannot_be_done_is_said_in_one_line(refused, tmp_path, begun, subtests):
    """With what was given, what is allowed, or what to do."""
    (tmp_path / "there").mkdir()
    for name in ("file", "file.py", "there/thesis.txt"):
        (tmp_path / name).write_text("all of it")
    for rest, told in REFUSED[begun].items():
        with subtests.test(line=f"{begun} {rest}"):
            assert told in refused(f"{begun} {rest}")


AMONG = {
    "audit runs": {
        "--reward arp": "No reward 'arp'. There is: plain, square. Those are recorded in 'runs'",
        "--gamma 0.9": "--gamma does not go with",
        "--episodes 100": "--episodes does not go with",
        "--task fd100-reach": "--task fd100-reach does not go with 'runs': name one of them",
        "--success done": "--success does not go with a folder of recorded trainings",
        "--budget 9": "--budget does not go with a folder of recorded trainings",
        "--random nowhere": "'nowhere' holds no recorded training",
    },
    "audit minari:m": {
        "--reward arp": "--places end_effector=0:3,target=3:6",
        "--reward arp --places end_effector=0:3,target=4:7": "beyond the 6 numbers",
        "--sim mujoco": "--sim does not go with a data set",
        "--success won": "It has: success",
        "--success sucess": "Did you mean 'success'?",
        "--success 'success>x'": "write KEY, or KEY>0.5",
        "--labels base/0.csv": "it needs episode and success",
        "--labels l.csv --success-above 1": "leave out one",
    },
    "audit": {"mine --random mine": "--random does not go with 'mine'"},
    "eta --baseline 'base/*.csv'": {
        "": "Missing option '--proposed'",
        "--proposed 'k2/*.csv' --baseline 'none/*.csv'": "No file matches 'none/*.csv'",
        "base/1.csv --proposed 'k2/*.csv'": "'base/1.csv' belongs to no flag",
        "--proposed 'k2/*.csv' --baseline k2/0.csv": "'k2/0.csv' is in both groups",
        "--proposed 'k2/*.csv' --baseline bad.csv": "bad.csv, line 3, column 'reward': 'two' is no finite",
        "--proposed 'k2/*.csv' --plot x.png": "--plot writes .html, not 'x.png'",
        "--proposed 'k2/*.csv' --plot no/x.html": "'no/x.html' cannot be",
        "--proposed 'k2/*.csv' --with-events": "0.csv has no event terms",
        "--proposed 'k2/*.csv' --curve odd": "'odd' is not one of",
        "--proposed 'k2/*.csv' --proposed-reward dense": "not paid by dense: k2",
    },
    "eta runs": {
        "--baseline 'base/*.csv'": "--baseline base/*.csv: no training was taught by it. There are: ",
        "--plot page.png": "--plot writes .html, not 'page.png'",
    },
    "eta logs": {
        "--baseline base --baseline prop": "one reward of a folder is the baseline",
    },
    "eta": {"k2": "are of 1 reward, `k2` 2; two are compared. Name them, --baseline", "odd": "Seen: 1 .xyz"},
    "report logs": {
        "--baseline nobody": "There are: base, prop",
        "--sort '{seed}'": "needs {reward} once",
        "--measure speed": "the logs tell success, return, length",
        "--per-step ,": "--per-step base=N,prop=N does",
        "--measure success --measure length": "one measure of the logs decides",
        "--measure length": "nobody says whether less or more",
        "--measure length:better=lower --ends length=0,8": "length is 9 in a training. Say the least",
        "--measure length:better=lower --ends length=0,80 --ends length=0,9": "once for a measure",
        "--as evaluations": "holds no recorded training and no log that is read. Seen: 4 .csv",
    },
    "report": {
        "runs runs": "'runs' holds recorded trainings: name one folder that all of them lie in",
        "minari:m lerobot:l": "One data set is reported at a time",
        "damaged": "0.monitor.csv",
        "odd": "Seen: 1 .xyz",
        "mine --summary mine": "is the folder of an experiment: name another",
        "mine --summary bad.csv": "The summary 'bad.csv' cannot be written",
    },
    "score": {
        "mine": "No reward is named",
        "mine --reward arpp": "Did you mean 'arp'?",
        "'mine/cells/*/trace.parquet' --reward arp --out one": "Several files of one name",
        "linked --reward dense": "linked/cells/other' is a link; nothing is written",
        "minari:m lerobot:l": "One data set is scored at a time",
    },
    "transfer": {
        "mine --to stock": "Did you mean 'stuck'?",
        "mine --to stuck:dt=1": "has no parameter 'dt'",
        "mine --jobs 0": "jobs=0: must be at least 1",
        "unfinished": "has no finished cell",
    },
    "verify": {"mine --repair --json": "--repair and --json"},
    "video mine": {
        "--cells zz": "none of the done cells have an id that begins so",
        "--out a.webm": ".gif or .mp4",
    },
}
"""The same of lines that name what is there: an experiment, recordings, data sets, logs, CSV files."""


@pytest.fixture
def place(finished, tmp_path):
    """What the lines name."""
    mine = tmp_path / finished(seeds=1)
    shutil.copytree(
        mine, tmp_path / "unfinished", ignore=lambda folder, names: names if folder.endswith("cells") else []
    )
    shutil.copytree(mine, tmp_path / "linked")
    (tmp_path / "linked/cells/other").symlink_to(tmp_path)
    for seed in range(2):
        pays = {"plain": lambda a: a, "square": lambda a: (a - 0.5) ** 2}
        record(tmp_path / f"runs/{seed}", "plain", seed, [0.1, 0.5, 0.9], pays=pays)
        for reward in ("base", "prop"):
            write_monitor(tmp_path / f"logs/{reward}/{seed}.monitor.csv", [seed, ord(reward[0])], [9, 9], [True, False])
        for name, rows in (("base", BASE), ("k2", K2)):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / f"{seed}.csv").write_text(HEADER + rows)
    episodes = [episode(6, number, number % 2 == 1) for number in range(12)]
    write_minari(tmp_path / "m", episodes)
    write_lerobot(tmp_path / "l", episodes)
    files = {
        "bad.csv": "reward\n1\ntwo\n",
        "odd/a.xyz": "?",
        "own.py": "def own(step):\n    return 0.5\n",
        "damaged/0.monitor.csv": '#{"t_start": 1.0}\nr,l,t\n1,oops,0\n',
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_what_cannot_be_done_with_a_folder_is_said_in_one_line(place, refused, subtests):
    """And the folder stays as it is."""
    for begun, lines in AMONG.items():
        for rest, told in lines.items():
            with subtests.test(line=f"{begun} {rest}"):
                assert told in refused(f"{begun} {rest}")


ENDS = {"=9,1": "NAME=LEAST,GREATEST, two numbers, the lower one first", "=0%,100%": "no percentages"}
SHARES = {"mine": "success_rate", "logs": "success"}


@pytest.mark.parametrize("command", ["report", "eta"])
def test_ends_are_refused_at_every_door_alike(place, refused, command):
    """Reversed, in percent, of a share, which has its own, and of a measure that nobody has."""
    for folder, share in SHARES.items():
        for given, told in {**ENDS, "=0,100": f"{share} is a share, from 0 to 1", "s=0,1": "No measure"}.items():
            assert told in refused(f"{command} {folder} --ends {share}{given}")
    for given, told in ENDS.items():
        assert told in refused(f"{command} runs --ends arm{given}")
    assert "--ends does not go with files of steps" in refused(
        "eta --baseline base/0.csv --proposed k2/0.csv --ends a=0,1"
    )


@pytest.mark.parametrize("command", ["run", "run --until decided", "choose --reward arp,dense"])
@pytest.mark.parametrize("where", ["--sim stuck --measure own", "--task gymnasium:id=CartPole-v1"])
def test_a_measure_without_a_direction_is_asked_about(refused, tmp_path, command, where):
    """Before anything is trained, in an environment and of an arm."""
    told = (
        "Measure 'own' decides, and nobody says whether less or more of it is better, or both are said: "
        "write lower_is_better = ['own']"
    )
    for said in ("", "lower_is_better = higher_is_better = ['own']\n"):
        (tmp_path / "own.py").write_text(f"{said}def own(step):\n    return 0.5 + step.action.sum(-1)\n")
        assert told in refused(f"{command} --measure own.py --algo random --steps 100 --out new {where}")
