from slider_drilling.api.activities import ActivitiesResult as ActivitiesResult
from slider_drilling.api.activities import activities as activities
from slider_drilling.api.batch import Batch as Batch
from slider_drilling.api.batch import batch as batch
from slider_drilling.api.diagnose import DiagnosisResult as DiagnosisResult
from slider_drilling.api.diagnose import diagnose as diagnose
from slider_drilling.api.replay import ReplayResult as ReplayResult
from slider_drilling.api.replay import replay as replay
from slider_drilling.api.rigs import load_rig as load_rig
from slider_drilling.api.rocking import rocking as rocking
from slider_drilling.api.simulate import Run as Run
from slider_drilling.api.simulate import simulate as simulate
from slider_drilling.api.study import StudyResult as StudyResult
from slider_drilling.api.study import study as study
from slider_drilling.api.with_effect import with_effect as with_effect
from slider_drilling.control.interface import Measurements as Measurements
from slider_drilling.control.interface import RigCommand as RigCommand
from slider_drilling.drillstring import Commands as Commands
from slider_drilling.drillstring import InitialState as InitialState
from slider_drilling.errors import InputError as InputError
from slider_drilling.log import RigLog as RigLog
from slider_drilling.log import read_log as read_log
from slider_drilling.rig import Rig as Rig

__version__: str
