import enum
from collections.abc import Sequence
from typing import Annotated, overload

import numpy
from numpy.typing import NDArray

class Status(enum.Enum):
    """What became of a row: the numbers of jink.Status."""

    none = 0

    updated = 1

    predicted = 2

    gated = 3

    restarted = 4

    initialised = 5

class MotionKind(enum.Enum):
    """Which motion model moves a state."""

    constant_velocity = 0

    constant_acceleration = 1

    singer = 2

    coordinated_turn = 3

    known_turn = 4

    current_statistical = 5

    augmented = 6

    two_stage = 7

    statistical_along_track = 8

    velocity_along_track = 9

class NoiseKind(enum.Enum):
    """Process noise: constant over a step (sd), or white (psd)."""

    piecewise = 0

    continuous = 1

class SensorKind(enum.Enum):
    """What a sensor measures."""

    position = 0

    position_velocity = 1

    bearing = 2

    polar = 3

class Vertical(enum.Enum):
    """What a polar sensor measures of the vertical."""

    none = 0

    elevation = 1

    height = 2

class Start(enum.Enum):
    """How many points a track starts from."""

    two_point = 0

    one_point = 1

    bounded_two_point = 2

class Adapt(enum.Enum):
    """What sets a mode's process noise."""

    none = 0

    current_statistical = 1

    fuzzy_limits = 2

    fuzzy_rules = 3

    network = 4

    straight_limits = 5

class Interaction(enum.Enum):
    """How the modes' past estimates interact."""

    imm = 0

    none = 1

    gpb1 = 2

    gpb2 = 3

class Propose(enum.Enum):
    """Which modes are alive in a scan."""

    all = 0

    digraph = 1

    active = 2

    grid = 3

    dimension = 4

class AidInputs(enum.Enum):
    """What a learned correction looks at."""

    none = 0

    residuals = 1

    innovations = 2

    sums = 3

    plane = 4

class AidModel(enum.Enum):
    """A network, or the shape of an ANFIS's membership functions."""

    network = 0

    triangular = 1

    gaussian = 2

    bell = 3

class Adaptation:
    """What sets a mode's process noise, or weighs the modes."""

    def __init__(
        self,
        *,
        kind: Adapt = Adapt.none,
        sizes: Sequence[int] = [],
        logarithmic: bool = False,
        numbers: Sequence[float] = [],
    ) -> None: ...
    @property
    def kind(self) -> Adapt: ...
    @property
    def numbers(self) -> list[float]: ...

class Mode:
    """A motion model in numbers."""

    def __init__(
        self,
        *,
        kind: MotionKind,
        axes: int,
        parameters: Sequence[float],
        prior_variance: Sequence[float],
        noise: NoiseKind = NoiseKind.piecewise,
        turn_noise: NoiseKind = NoiseKind.piecewise,
    ) -> None: ...
    @property
    def kind(self) -> MotionKind: ...
    @property
    def noise(self) -> NoiseKind: ...
    @property
    def has_acceleration(self) -> bool: ...
    @property
    def has_turn_rate(self) -> bool: ...
    def alike(self, other: Mode) -> bool:
        """Of one motion model, so that they differ in numbers only?"""

    @property
    def prior_variance(self) -> list[float]: ...
    @property
    def parameters(self) -> list[float]: ...
    @parameters.setter
    def parameters(self, arg: Sequence[float], /) -> None: ...
    @property
    def adaptation(self) -> Adaptation: ...
    @adaptation.setter
    def adaptation(self, arg: Adaptation, /) -> None: ...
    @property
    def level(self) -> list[float]: ...
    @level.setter
    def level(self, arg: Sequence[float], /) -> None: ...
    @property
    def around_side(self) -> bool: ...
    @around_side.setter
    def around_side(self, arg: bool, /) -> None: ...
    @property
    def in_sd(self) -> bool: ...
    @in_sd.setter
    def in_sd(self, arg: bool, /) -> None: ...

class Sensor:
    """A sensor in numbers: variances, or a packed covariance if correlated."""

    def __init__(
        self,
        *,
        kind: SensorKind,
        axes: int,
        rows: int,
        noise: Sequence[float],
        log_extent: Sequence[float],
        correlated: bool = False,
        vertical: Vertical = Vertical.none,
        range_rate: bool = False,
        from_north: bool = True,
        converted: bool = False,
        site: Sequence[float] = [0.0, 0.0, 0.0],
        radius: float = 0.0,
    ) -> None: ...
    @property
    def kind(self) -> SensorKind: ...
    @property
    def axes(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def correlated(self) -> bool: ...
    @property
    def vertical(self) -> Vertical: ...
    @property
    def range_rate(self) -> bool: ...
    @property
    def from_north(self) -> bool: ...
    @property
    def site(self) -> list[float]: ...
    @property
    def radius(self) -> float: ...
    @property
    def converted(self) -> bool: ...
    @property
    def noise(self) -> list[float]: ...
    @property
    def log_extent(self) -> list[float]: ...

class Proposal:
    """Which modes of a large set are alive."""

    def __init__(
        self,
        *,
        kind: Propose = Propose.all,
        slots: int = 0,
        start: Sequence[float] = [],
        neighbours: Sequence[Sequence[int]] = [],
        numbers: Sequence[float] = [],
    ) -> None: ...
    @property
    def kind(self) -> Propose: ...

class Detection:
    """Input estimation beside one mode; window 0 for none."""

    def __init__(self, *, window: int = 0, shortest: int = 1, threshold: float = 0.0) -> None: ...
    @property
    def window(self) -> int: ...

class Coasting:
    """
    What a target does while nothing is measured; after 0: it goes on as it was.
    """

    def __init__(
        self, *, after: float = 0.0, manoeuvre: float = 1.0, climb: float = 1.0, reverses: bool = True
    ) -> None: ...
    @property
    def after(self) -> float: ...
    @property
    def reverses(self) -> bool: ...

class Aid:
    """A learned correction of what goes out."""

    def __init__(
        self,
        *,
        kind: AidInputs = AidInputs.none,
        model: AidModel = AidModel.network,
        inputs: int = 0,
        outputs: int = 0,
        sizes: Sequence[int] = [],
        numbers: Sequence[float] = [],
    ) -> None: ...
    @property
    def kind(self) -> AidInputs: ...

class Declaration:
    """A whole filter, before it is made ready to run."""

    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, other: Declaration) -> None: ...
    @property
    def modes(self) -> list[Mode]: ...
    @modes.setter
    def modes(self, arg: Sequence[Mode], /) -> None: ...
    @property
    def sensors(self) -> list[Sensor]: ...
    @sensors.setter
    def sensors(self, arg: Sequence[Sensor], /) -> None: ...
    @property
    def continuous(self) -> bool: ...
    @continuous.setter
    def continuous(self, arg: bool, /) -> None: ...
    @property
    def transition(self) -> list[float]: ...
    @transition.setter
    def transition(self, arg: Sequence[float], /) -> None: ...
    @property
    def initial_probability(self) -> list[float]: ...
    @initial_probability.setter
    def initial_probability(self, arg: Sequence[float], /) -> None: ...
    @property
    def unscented(self) -> bool: ...
    @unscented.setter
    def unscented(self, arg: bool, /) -> None: ...
    @property
    def unbiased_mixing(self) -> bool: ...
    @unbiased_mixing.setter
    def unbiased_mixing(self, arg: bool, /) -> None: ...
    @property
    def outlier_share(self) -> float: ...
    @outlier_share.setter
    def outlier_share(self, arg: float, /) -> None: ...
    @property
    def restart_after(self) -> int: ...
    @restart_after.setter
    def restart_after(self, arg: int, /) -> None: ...
    @property
    def hindsight(self) -> bool: ...
    @hindsight.setter
    def hindsight(self, arg: bool, /) -> None: ...
    @property
    def coast(self) -> float: ...
    @coast.setter
    def coast(self, arg: float, /) -> None: ...
    @property
    def coasting(self) -> Coasting: ...
    @coasting.setter
    def coasting(self, arg: Coasting, /) -> None: ...
    @property
    def start(self) -> Start: ...
    @start.setter
    def start(self, arg: Start, /) -> None: ...
    @property
    def velocity_variance(self) -> float: ...
    @velocity_variance.setter
    def velocity_variance(self, arg: float, /) -> None: ...
    @property
    def interaction(self) -> Interaction: ...
    @interaction.setter
    def interaction(self, arg: Interaction, /) -> None: ...
    @property
    def side(self) -> list[Mode]: ...
    @side.setter
    def side(self, arg: Sequence[Mode], /) -> None: ...
    @property
    def proposal(self) -> Proposal: ...
    @proposal.setter
    def proposal(self, arg: Proposal, /) -> None: ...
    @property
    def scores(self) -> Adaptation: ...
    @scores.setter
    def scores(self, arg: Adaptation, /) -> None: ...
    @property
    def detection(self) -> Detection: ...
    @detection.setter
    def detection(self, arg: Detection, /) -> None: ...
    @property
    def aid(self) -> Aid: ...
    @aid.setter
    def aid(self, arg: Aid, /) -> None: ...
    @property
    def columns(self) -> int:
        """Of the measurement with the most components."""

largest_own: int = 16

def mix(
    x: Sequence[Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)]],
    P: Sequence[Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)]],
    w: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def update(
    x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    y: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    H: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    R: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    present: Annotated[NDArray[numpy.bool_], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def root(
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    semidefinite: bool = False,
    least: float = 1e-300,
) -> NDArray[numpy.float64]: ...
def solve(
    L: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    X: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    transposed: bool = False,
) -> NDArray[numpy.float64]: ...
def linearise_motion(
    motion: Mode,
    unscented: bool,
    dt: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    input: object | None,
) -> tuple: ...
def observe_sensor(
    sensor: Sensor, x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)]
) -> tuple: ...
def position_of(
    sensor: Sensor,
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    R: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    present: Annotated[NDArray[numpy.bool_], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def transition_over(
    continuous: bool,
    matrix: Sequence[float],
    modes: int,
    dt: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]: ...

largest_population_modes: int = 5

def population_errors(
    tables: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    count: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    transition: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    probability: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    position: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    variance: float,
    result: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu")],
    threads: int,
) -> None: ...
def candidate_errors(
    engine: Engine,
    numbers: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    offsets: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    truth: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    sums: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu")],
    threads: int,
) -> None:
    """
    Of one filter with many sets of numbers: squared errors per scan, and how many tracks they are of, into sums.
    """

class Figure(enum.Enum):
    """Which figure of a filter is differentiated."""

    log_likelihood = 0

    prediction_error = 1

    tracking_error = 2

def numbers(engine: Engine) -> list[float]:
    """The numbers the filter can be differentiated by."""

def differentiable(engine: Engine) -> bool:
    """Whether the filter's figures have derivatives by them."""

def gradient(
    engine: Engine,
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    columns: int,
    offsets: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    sensor: object | None,
    noise: object | None,
    full_noise: bool,
    input: object | None,
    prior_x: object | None,
    prior_P: object | None,
    figure: Figure,
    ahead: int,
    components: Sequence[int],
    target: object | None,
    weight: object | None,
    tangents: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    value: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu")],
    slope: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu")],
    threads: int,
) -> None:
    """
    Sums of a figure per track into value (tracks, sums), their derivatives along the tangents into slope.
    """

def first_indefinite(
    matrices: Annotated[
        NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)
    ],
) -> int: ...
def first_indefinite_row(size: int, columns: list) -> int: ...
def keep_freed_memory() -> None: ...
def usual_step(
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    new: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    spacing: int,
) -> float: ...
def third_differences(
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    values: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    new: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    longest: float,
    rounding: float,
    spacing: int,
) -> tuple: ...
def grouped_quantile(
    values: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    group: Annotated[NDArray[numpy.int64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    groups: int,
    share: float,
    least: int,
) -> object: ...
def rough_velocity(
    time: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    plane: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    new: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    reach: int,
) -> object: ...
def ways(
    plane: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    new: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    reach: Annotated[NDArray[numpy.int64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    noise: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
) -> tuple: ...
def off(
    velocity: Annotated[NDArray[numpy.float64], dict(shape=(None, None), device="cpu", writable=False)],
    shown: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    way: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)] | None,
) -> object: ...
def along_the_way(
    along: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    way: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(shape=(None, None), device="cpu", writable=False)],
) -> tuple: ...
def across_and_along(
    difference: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    index: Annotated[NDArray[numpy.int64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)],
    least: float,
) -> tuple: ...
def manoeuvring(
    time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    first: Annotated[NDArray[numpy.int64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    last: Annotated[NDArray[numpy.int64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    mode: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    velocity: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    variance: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    acceleration: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)]
    | None,
    spread: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)] | None,
    window: float,
    straight: float,
    threshold: float,
) -> object: ...
def windows(
    time: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    begins: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    back: float,
    ahead: float,
) -> tuple: ...

earth_equator: float = 6378137.0

earth_flattening: float = 0.0033528106647474805

def geodesics_between(
    latitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    longitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    to_latitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    to_longitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu")]: ...
def geodesics_ahead(
    x: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    y: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    anchor_x: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    anchor_y: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    latitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    longitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    convergence: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu")]: ...
def legs(
    latitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    longitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    first: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    longest: float,
) -> tuple: ...
def laid(
    latitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    longitude: Annotated[NDArray[numpy.float64], dict(shape=(None,), device="cpu", writable=False)],
    first: Annotated[NDArray[numpy.bool_], dict(shape=(None,), order="C", device="cpu", writable=False)],
    table: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu")],
) -> None: ...

class TextFormat(enum.Enum):
    json = 0

    csv = 1

class TextRows:
    def __init__(self, table: object, format: TextFormat, header: bool) -> None: ...
    @property
    def supported(self) -> bool: ...
    def fill(self, to: Annotated[NDArray[numpy.uint8], dict(shape=(None,), order="C", device="cpu")]) -> int: ...

lanes: int = 8

class Engine:
    def __init__(self, declaration: Declaration) -> None: ...
    def run(
        self,
        time: Annotated[NDArray[numpy.float64], dict(order="C", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", writable=False)],
        columns: int,
        offsets: Annotated[NDArray[numpy.int64], dict(order="C", writable=False)],
        sensor: object | None,
        noise: object | None,
        full_noise: bool,
        input: object | None,
        prior_x: object | None,
        prior_P: object | None,
        results: list,
        status: object | None,
        covariances: list,
        smooth: bool,
        until: object | None,
        threads: int,
    ) -> None: ...
    def one(self, lag: int, filter: object | None = None) -> LiveOne: ...
    def many(self, arg0: int, arg1: int, /) -> LiveMany: ...
    def slots(self) -> LiveSlots: ...
    def association(self, rules: ManyRules, sensors: Sequence[SensorView]) -> Many: ...

class Estimate:
    @property
    def time(self) -> float: ...
    @property
    def x(self) -> object: ...
    @property
    def P(self) -> object: ...
    @property
    def mode_probability(self) -> object: ...
    @property
    def log_likelihood(self) -> float: ...
    @property
    def nis(self) -> float: ...
    @property
    def nis_dof(self) -> float: ...
    @property
    def status(self) -> str: ...
    @property
    def doubt(self) -> float:
        """
        Probability that the measurement is an outlier, where the next one decides; else 0.
        """

    @property
    def decided(self) -> str | None:
        """The status of the measurement before, if that was in doubt until now."""

    @property
    def components(self) -> tuple: ...
    def __getitem__(self, component: str) -> float:
        """One component's estimate, by name."""

    def sd(self, component: str) -> float:
        """One component's standard deviation, by name."""

    def __repr__(self) -> str: ...

class LiveOne:
    def update(
        self,
        t: object,
        z: object | None,
        sensor: int = 0,
        covariance: object | None = None,
        input: object | None = None,
    ) -> Estimate:
        """
        One measurement at time t; returns the estimate it leads to. A missing z is None, a missing component NaN or None.
        """

    def predict(self, t: object) -> Estimate:
        """The estimate expected at time t; the live state is not touched."""

    def begin(
        self,
        x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        time: float,
    ) -> None:
        """Start from a given state at a time."""

    def reset(self) -> None:
        """Forget the target; the next position starts a new one."""

    def save(self) -> bytes:
        """The state as bytes, the same on every machine."""

    def restore(self, state: bytes) -> None:
        """Take up a saved state."""

    def __reduce__(self) -> tuple: ...

class LiveMany:
    def update(
        self,
        t: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        sensor: object | None,
        noise: object | None,
        input: object | None,
        results: list,
        predict_only: bool,
    ) -> None: ...
    def follow(
        self,
        t: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        noise: object | None,
        results: list,
    ) -> None: ...
    def begin(
        self,
        target: int,
        x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        time: float,
    ) -> None: ...
    def reset(self, target: int) -> None: ...
    def time(self, arg: int, /) -> float: ...
    def save(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...

class LiveSlots:
    def begin_all(
        self,
        x: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        P: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    ) -> None:
        """Let new targets start from a given state."""

    def take(self) -> int:
        """A slot for a new target."""

    def release(self, slot: int) -> None:
        """The slot's target has gone."""

    @property
    def in_use(self) -> int: ...
    def update(
        self,
        slots: Annotated[NDArray[numpy.int32], dict(order="C", device="cpu", writable=False)],
        t: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        results: list,
    ) -> None: ...

def marginals(
    begin: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    plot: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    psi: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    plots: int,
    exactly: bool = False,
    tolerance: float = 0.0001,
    sweeps: int = 200,
) -> tuple:
    """
    Marginals of sparse association weights: of each edge, of each row without a plot, of each plot without a row, and sweeps.
    """

def log_total(
    begin: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    plot: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    psi: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    plots: int,
) -> float:
    """
    Logarithm of the sum over all assignments of the product of their weights.
    """

def assign(
    begin: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    plot: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    cost: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
    plots: int,
) -> list[int]:
    """
    The plot of each row, or -1, at the least total cost; a row without costs 0.
    """

def cluster(
    begin: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    plot: Annotated[NDArray[numpy.int64], dict(order="C", device="cpu", writable=False)],
    plots: int,
) -> list[int]:
    """Which cluster each row is in, or -1."""

class Association(enum.Enum):
    """How plots are given to tracks."""

    marginal = 0

    jpda = 1

    pda = 2

    gnn = 3

    nearest = 4

class SensorView:
    """What a sensor sees of what is there, and what it sees that is not."""

    def __init__(self) -> None: ...
    @property
    def detection(self) -> float: ...
    @detection.setter
    def detection(self, arg: float, /) -> None: ...
    @property
    def clutter(self) -> float: ...
    @clutter.setter
    def clutter(self, arg: float, /) -> None: ...
    @property
    def undetected(self) -> float: ...
    @undetected.setter
    def undetected(self, arg: float, /) -> None: ...
    @property
    def arrivals(self) -> float: ...
    @arrivals.setter
    def arrivals(self, arg: float, /) -> None: ...
    @property
    def reach(self) -> float: ...
    @reach.setter
    def reach(self, arg: float, /) -> None: ...
    @property
    def area(self) -> float: ...
    @area.setter
    def area(self, arg: float, /) -> None: ...
    @property
    def scanning(self) -> bool: ...
    @scanning.setter
    def scanning(self, arg: bool, /) -> None: ...
    @property
    def learning(self) -> bool: ...
    @learning.setter
    def learning(self, arg: bool, /) -> None: ...
    @property
    def scans(self) -> int: ...
    def within(self, arg0: float, arg1: float, arg2: float, arg3: float, /) -> None: ...
    def around(self, arg0: float, arg1: float, arg2: float, /) -> None: ...

class ManyRules:
    """Gates and the life cycle of tracks."""

    def __init__(self) -> None: ...
    @property
    def association(self) -> Association: ...
    @association.setter
    def association(self, arg: Association, /) -> None: ...
    @property
    def gate(self) -> float: ...
    @gate.setter
    def gate(self, arg: float, /) -> None: ...
    @property
    def split_gate(self) -> float: ...
    @split_gate.setter
    def split_gate(self, arg: float, /) -> None: ...
    @property
    def confirm(self) -> float: ...
    @confirm.setter
    def confirm(self, arg: float, /) -> None: ...
    @property
    def keep(self) -> float: ...
    @keep.setter
    def keep(self, arg: float, /) -> None: ...
    @property
    def drop(self) -> float: ...
    @drop.setter
    def drop(self, arg: float, /) -> None: ...
    @property
    def life(self) -> float: ...
    @life.setter
    def life(self, arg: float, /) -> None: ...
    @property
    def drop_after(self) -> float: ...
    @drop_after.setter
    def drop_after(self, arg: float, /) -> None: ...
    @property
    def established(self) -> float: ...
    @established.setter
    def established(self, arg: float, /) -> None: ...
    @property
    def left(self) -> float: ...
    @left.setter
    def left(self, arg: float, /) -> None: ...
    @property
    def abreast(self) -> float: ...
    @abreast.setter
    def abreast(self, arg: float, /) -> None: ...
    @property
    def sure(self) -> float: ...
    @sure.setter
    def sure(self, arg: float, /) -> None: ...
    @property
    def inherit(self) -> float: ...
    @inherit.setter
    def inherit(self, arg: float, /) -> None: ...
    @property
    def merge_within(self) -> float: ...
    @merge_within.setter
    def merge_within(self, arg: float, /) -> None: ...
    @property
    def merge_after(self) -> int: ...
    @merge_after.setter
    def merge_after(self, arg: int, /) -> None: ...
    @property
    def split(self) -> bool: ...
    @split.setter
    def split(self, arg: bool, /) -> None: ...
    @property
    def unclaimed(self) -> float: ...
    @unclaimed.setter
    def unclaimed(self, arg: float, /) -> None: ...
    @property
    def leave(self) -> float: ...
    @leave.setter
    def leave(self, arg: float, /) -> None: ...
    @property
    def patience(self) -> float: ...
    @patience.setter
    def patience(self, arg: float, /) -> None: ...
    @property
    def young(self) -> int: ...
    @young.setter
    def young(self, arg: int, /) -> None: ...
    @property
    def crowd(self) -> int: ...
    @crowd.setter
    def crowd(self, arg: int, /) -> None: ...
    @property
    def most_plots(self) -> int: ...
    @most_plots.setter
    def most_plots(self, arg: int, /) -> None: ...
    @property
    def most_tracks(self) -> int: ...
    @most_tracks.setter
    def most_tracks(self, arg: int, /) -> None: ...
    @property
    def likelihood(self) -> bool: ...
    @likelihood.setter
    def likelihood(self, arg: bool, /) -> None: ...
    @property
    def threads(self) -> int: ...
    @threads.setter
    def threads(self, arg: int, /) -> None: ...

class Many:
    """Many targets from plots without identity."""

    def scan(
        self,
        time: float,
        sensor: int,
        z: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        noise: object | None,
        unit: object | None,
        code: object | None,
        times: object | None,
        sector: object | None = None,
    ) -> dict: ...
    def tracks(self, least: float, covariance: bool) -> dict: ...
    def taken(self, least: float) -> dict: ...
    def add(
        self,
        arg0: float,
        arg1: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        arg2: Annotated[NDArray[numpy.float64], dict(order="C", device="cpu", writable=False)],
        arg3: float,
        /,
    ) -> int: ...
    def view(self, arg: int, /) -> SensorView: ...
    def set_view(self, arg0: int, arg1: SensorView, /) -> None: ...
    def lone(self) -> object: ...
    @property
    def time(self) -> float: ...
    def living(self) -> int: ...
    def save(self) -> bytes: ...
    def restore(self, state: bytes) -> None: ...
