"""Named errors. Each message says what was expected, what came, and what to do."""


class JointAttnError(Exception):
    """Base of every error that this package raises on purpose."""


class ConfigError(JointAttnError, ValueError):
    """An option has a value that cannot work."""


class ActionError(JointAttnError, ValueError):
    """An action is not what the task takes: not finite, of another shape, or no numbers."""


class ObservationError(JointAttnError, ValueError):
    """What is to be perceived, counted or learned from is not what is taken: shape, kind, or values out of range."""


class StateError(JointAttnError, ValueError):
    """A saved state cannot be restored here."""


class EpisodeError(JointAttnError, RuntimeError):
    """A step was asked for before an episode began, or after it was over."""


class ClosedError(JointAttnError, RuntimeError):
    """What was closed was used again."""


class GLError(JointAttnError, RuntimeError):
    """No image can be rendered on this machine as it is."""


class OutputError(JointAttnError, OSError):
    """An output folder or file cannot be used, or holds something else."""


class CheckpointError(JointAttnError, RuntimeError):
    """A checkpoint is damaged, or belongs to another run."""


class NotFiniteError(JointAttnError, ArithmeticError):
    """What a run has learned or simulated is no finite number any more."""


class VideoError(JointAttnError, RuntimeError):
    """The video cannot be written: no ffmpeg program, or it gave up."""


class FootageError(JointAttnError, RuntimeError):
    """A file is no video that can be read, or one that cannot be perceived as asked."""


class SeriesError(JointAttnError, ValueError):
    """Observations cannot be measured as they are: unequal lengths, missing values, what is no code."""


class TrialError(JointAttnError, ValueError):
    """A trial of an experiment has a config or a result that cannot be stored."""


class SweepError(JointAttnError, RuntimeError):
    """Experiments cannot be found, or the workers that were asked for cannot be reached."""


class CommandError(JointAttnError, RuntimeError):
    """A command that was to be measured has failed."""


class ExtraError(JointAttnError, ImportError):
    """What was asked for needs an optional package that is not installed."""
