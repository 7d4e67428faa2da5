"""Names of the package and the modules that they are in."""

from rodgen.analyse.branches.boundary import stability_boundary as stability_boundary
from rodgen.analyse.branches.coexistence import static_equilibria as static_equilibria
from rodgen.analyse.branches.equilibrium_branch import continue_equilibria as continue_equilibria
from rodgen.analyse.chaos.exponents import Exponents as Exponents
from rodgen.analyse.chaos.exponents import lyapunov_exponents as lyapunov_exponents
from rodgen.analyse.chaos.section import poincare_section as poincare_section
from rodgen.analyse.chaos.zero_one import zero_one_test as zero_one_test
from rodgen.analyse.critical import Critical as Critical
from rodgen.analyse.critical import critical_force as critical_force
from rodgen.analyse.cycles.branches import continue_cycles as continue_cycles
from rodgen.analyse.cycles.cycle import Cycle as Cycle
from rodgen.analyse.cycles.floquet import Floquet as Floquet
from rodgen.analyse.cycles.floquet import floquet as floquet
from rodgen.analyse.cycles.nonlinear_modes import continue_mode as continue_mode
from rodgen.analyse.cycles.nonlinear_modes import nonlinear_mode as nonlinear_mode
from rodgen.analyse.cycles.periodic_motion import find_cycle as find_cycle
from rodgen.analyse.extrapolate import Extrapolation as Extrapolation
from rodgen.analyse.extrapolate import richardson as richardson
from rodgen.analyse.fourier import Spectrum as Spectrum
from rodgen.analyse.fourier import spectrum as spectrum
from rodgen.analyse.growth import SimulatedCritical as SimulatedCritical
from rodgen.analyse.growth import simulated_critical_force as simulated_critical_force
from rodgen.analyse.modes import Modes as Modes
from rodgen.analyse.modes import natural_modes as natural_modes
from rodgen.analyse.precision.work_precision import WorkPrecision as WorkPrecision
from rodgen.analyse.precision.work_precision import work_precision as work_precision
from rodgen.analyse.statics import Equilibrium as Equilibrium
from rodgen.analyse.statics import static_equilibrium as static_equilibrium
from rodgen.errors import AnalysisError as AnalysisError
from rodgen.errors import BranchInterrupted as BranchInterrupted
from rodgen.errors import InputError as InputError
from rodgen.errors import MeshWarning as MeshWarning
from rodgen.errors import StudyError as StudyError
from rodgen.integrate.endings import StepWarning as StepWarning
from rodgen.integrate.ensemble import Ensemble as Ensemble
from rodgen.integrate.files.reader import load as load
from rodgen.integrate.files.result_file import FileWarning as FileWarning
from rodgen.integrate.many import simulate_many as simulate_many
from rodgen.integrate.methods.choose import choose as choose
from rodgen.integrate.simulate import resume as resume
from rodgen.integrate.simulate import simulate as simulate
from rodgen.integrate.solution import Interrupted as Interrupted
from rodgen.integrate.solution import RunError as RunError
from rodgen.integrate.solution import Solution as Solution
from rodgen.integrate.trajectory import Event as Event
from rodgen.loading.build import build as build
from rodgen.native.library import BuildError as BuildError
from rodgen.scene import Scene as Scene
from rodgen.scene import Structure as Structure
from rodgen.studies.engine import study as study
from rodgen.studies.study import Study as Study
from rodgen.system import System as System

__all__: list[str]
__version__: str
