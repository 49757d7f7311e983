from slider_drilling.api.batches import Batch as Batch
from slider_drilling.api.batches import batch as batch
from slider_drilling.api.comparisons import Replayed as Replayed
from slider_drilling.api.comparisons import replay as replay
from slider_drilling.api.diagnoses import Diagnosed as Diagnosed
from slider_drilling.api.diagnoses import diagnose as diagnose
from slider_drilling.api.motion import rocking as rocking
from slider_drilling.api.planting import planted as planted
from slider_drilling.api.rigs import load_rig as load_rig
from slider_drilling.api.runs import Run as Run
from slider_drilling.api.runs import simulate as simulate
from slider_drilling.api.studies import Studied as Studied
from slider_drilling.api.studies import study as study
from slider_drilling.control.interface import Measurements as Measurements
from slider_drilling.control.interface import RigCommand as RigCommand
from slider_drilling.drillstring import Commands as Commands
from slider_drilling.drillstring import Start as Start
from slider_drilling.errors import InputError as InputError
from slider_drilling.log import RigLog as RigLog
from slider_drilling.log import read_log as read_log
from slider_drilling.rig import Rig as Rig

__version__: str
