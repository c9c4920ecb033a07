"""What commands are written with: flags, output, experiments, runs, results. Commands of our own use it too.

Every name is looked up when it is first used, so that importing this module imports nothing heavy.
"""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.cli.commands import hidden_commands as hidden_commands
    from harness.cli.datasets import names_dataset as names_dataset
    from harness.cli.fail_on import Said as Said, named_answers as named_answers, status_of as status_of
    from harness.cli.flags.dataset import Partial as Partial, Places as Places
    from harness.cli.flags.logs import AsFormat as AsFormat, LeftOut as LeftOut, SortBy as SortBy
    from harness.cli.flags.shared import (
        REWARDS as REWARDS,
        ROBOT as ROBOT,
        ROBOTS as ROBOTS,
        SIMULATORS as SIMULATORS,
        TASKS as TASKS,
        AsJson as AsJson,
        ExperimentFolder as ExperimentFolder,
        FailOn as FailOn,
        Measures as Measures,
        PluginFiles as PluginFiles,
        RobotName as RobotName,
        TaskName as TaskName,
        flag as flag,
    )
    from harness.cli.output import (
        audits_of as audits_of,
        complain as complain,
        kept_when_interrupted as kept_when_interrupted,
        pays_of as pays_of,
        say as say,
        say_json as say_json,
    )
    from harness.cli.progress import left_text as left_text
    from harness.cli.records import Records as Records
    from harness.cli.runnable import example_run as example_run, usable as usable
    from harness.cli.unexpected import describe_unexpected as describe_unexpected
    from harness.env import ReachVectorEnv as ReachVectorEnv
    from harness.env.solid_probes import (
        Probe as Probe,
        few_points as few_points,
        find_missing as find_missing,
        missing_in_words as missing_in_words,
        probes_of as probes_of,
    )
    from harness.eta.auc import Auc as Auc, share_of as share_of
    from harness.eta.headline import SUCCESS as SUCCESS
    from harness.eta.index import NEAR_ZERO as NEAR_ZERO, NOTHING as NOTHING
    from harness.eta.laws import Account as Account, Missing as Missing, is_left_out as is_left_out
    from harness.eta.manner import ACTED_AT_RANDOM as ACTED_AT_RANDOM
    from harness.eta.rescaling import PayLine as PayLine, rounded as rounded
    from harness.experiment.arm_evaluation import record_evaluation as record_evaluation
    from harness.experiment.environments.frames import strip_of as strip_of
    from harness.experiment.environments.plan import (
        columns_of as columns_of,
        look_at as look_at,
    )
    from harness.experiment.environments.played_again import (
        PlayedAgain as PlayedAgain,
        let_draw as let_draw,
        picture_of as picture_of,
    )
    from harness.experiment.environments.spaces import (
        flat_observation as flat_observation,
    )
    from harness.experiment.provenance import (
        CHECKOUT as CHECKOUT,
        describe_environment as describe_environment,
        describe_machine as describe_machine,
        source_commit as source_commit,
        versions_behind as versions_behind,
    )
    from harness.experiment.run_cell import draft_of as draft_of, leave_record as leave_record
    from harness.experiment.workers.order import Report as Report
    from harness.experiment.workers.workers import News as News, run_orders as run_orders, worker_count as worker_count
    from harness.files.bounded import (
        files_in as files_in,
        parse_json as parse_json,
        read_bytes as read_bytes,
        whole_file as whole_file,
    )
    from harness.log.log import ROWS as ROWS
    from harness.log.open_log import Found as Found, find_logs as find_logs
    from harness.payoff.dataset.arm_pay import places_of as places_of
    from harness.payoff.dataset.paid_dataset import Labels as Labels, PaidDataset as PaidDataset
    from harness.payoff.dataset.rewards import given_rewards as given_rewards, rewards_of as rewards_of
    from harness.payoff.dataset.steps import Payer as Payer
    from harness.payoff.rollout import (
        CREEP as CREEP,
        FINISH as FINISH,
        HOLD as HOLD,
        HOVER as HOVER,
        Finishing as Finishing,
        NoScriptsError as NoScriptsError,
        Payoff as Payoff,
        Score as Score,
        States as States,
        on_finishing as on_finishing,
        on_terms as on_terms,
        paid_along as paid_along,
        pay_along as pay_along,
        under_noise as under_noise,
    )
    from harness.policy.policy import (
        MEAN as MEAN,
        STD as STD,
        ContinuousNetwork as ContinuousNetwork,
        read_folder as read_folder,
    )
    from harness.record.cell import (
        Ending as Ending,
        now as now,
        read_record as read_record,
        require_files as require_files,
    )
    from harness.record.dataset.labels import (
        UNKNOWN as UNKNOWN,
        SuccessRule as SuccessRule,
        parse_success as parse_success,
        read_labels as read_labels,
    )
    from harness.record.dataset.open_dataset import (
        MOST_EPISODES as MOST_EPISODES,
        DatasetFacts as DatasetFacts,
        dataset_facts as dataset_facts,
        open_dataset as open_dataset,
    )
    from harness.record.file_forms import (
        ChoiceForm as ChoiceForm,
        Chosen as Chosen,
        Status as Status,
        read_form as read_form,
    )
    from harness.record.folder import TRAINING_RECORDING as TRAINING_RECORDING, parts_of as parts_of
    from harness.record.out_folder import (
        folder_lock as folder_lock,
        is_held as is_held,
        make_folder as make_folder,
        refuse_links as refuse_links,
        storage_errors as storage_errors,
    )
    from harness.record.recording.facts import (
        facts_of as facts_of,
        file_column as file_column,
        term_column as term_column,
    )
    from harness.record.recording.recorded_training import (
        FLAGS as FLAGS,
        INTEGERS as INTEGERS,
        TICK as TICK,
        TICK_IN_FILE as TICK_IN_FILE,
        is_recording as is_recording,
        part_paths as part_paths,
        read_facts as read_facts,
        read_recorder as read_recorder,
        recorder_numbers as recorder_numbers,
        recordings_in as recordings_in,
    )
    from harness.record.returns import PAID as PAID, mean_return as mean_return
    from harness.record.scene import Scene as Scene, read_scene as read_scene, write_scene as write_scene
    from harness.record.status import FolderStatus as FolderStatus, read_status as read_status
    from harness.record.trace import TERM as TERM
    from harness.recorder.column import Column as Column, made_columns as made_columns, source_of as source_of
    from harness.recorder.env_facts import Columns as Columns, versions_of as versions_of
    from harness.recorder.guard import Guard as Guard, Raised as Raised
    from harness.recorder.record_rewards import RecordRewards as RecordRewards
    from harness.recorder.recorder import differs as differs
    from harness.recorder.sealed import KeepWalks as KeepWalks, Walk as Walk
    from harness.registry.choice import kind_of_task as kind_of_task, require_known as require_known
    from harness.registry.given import plugin_flags as plugin_flags, read_given as read_given
    from harness.registry.plugin_module import import_file as import_file
    from harness.registry.registry import load_registry as load_registry
    from harness.registry.spec import (
        PLANNED as PLANNED,
        blamed_on as blamed_on,
        is_met as is_met,
        require_pillow as require_pillow,
    )
    from harness.registry.targets import examined as examined
    from harness.report.tables.grid import Terminal as Terminal, show as show
    from harness.results.comparison import deciding_manner as deciding_manner
    from harness.results.learning import Learning as Learning
    from harness.results.logs.read_logs import (
        account_of as account_of,
        facts_notes as facts_notes,
        read_trainings as read_trainings,
        require_comparable as require_comparable,
    )
    from harness.results.logs.results_of_logs import sort_found as sort_found
    from harness.results.overview import (
        decided_by_text as decided_by_text,
        measure_text as measure_text,
        overview_of as overview_of,
        short_name as short_name,
    )
    from harness.results.recordings.episodes import (
        LAST_SHARE as LAST_SHARE,
        Episodes as Episodes,
        Part as Part,
        count_text as count_text,
    )
    from harness.results.recordings.recordings import (
        account_of_runs as account_of_runs,
        env_of as env_of,
        has_recordings as has_recordings,
        read_all as read_all,
    )
    from harness.results.recordings.runs import (
        NO_NAME as NO_NAME,
        Run as Run,
    )
    from harness.results.replay import Episode as Episode, Show as Show, Side as Side, find_done as find_done
    from harness.results.table import RANDOM as RANDOM
    from harness.results.trainings import Alone as Alone
    from harness.results.verdicts import COUNTED as COUNTED
    from harness.reward.given import (
        FIELDS as FIELDS,
        OWN as OWN,
        Before as Before,
        Now as Now,
        Untold as Untold,
        told_under as told_under,
        zeros_of as zeros_of,
    )
    from harness.reward.steps import (
        BEFORE as BEFORE,
        DISTANCE as DISTANCE,
        step_between as step_between,
        steps_type as steps_type,
    )
    from harness.reward.terms import paid_twice as paid_twice, paid_twice_text as paid_twice_text
    from harness.scene.picture import (
        BACKGROUND as BACKGROUND,
        TARGET as TARGET,
        chain_of as chain_of,
        corners_of as corners_of,
        draw_arm as draw_arm,
    )
    from harness.score.places import ArmPlaces as ArmPlaces

else:
    __all__, __getattr__ = face_of(__name__, __file__)
