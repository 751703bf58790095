"""Learner with any torch network between the face and the population of output units.

Give ``NetworkLearner`` a module of your own that maps the activations (k,) of a face to those of the output
units, flat.
"""

from typing import Any

import numpy as np

from jointattn_mj.errors import ConfigError
from jointattn_mj.gaze_following.learners import LearnerConfig, Locations, PopulationCode, locations_in_view, same_shape
from jointattn_mj.io.extras import extra

extra("torch", "torch")
import torch  # noqa: E402


class HiddenLayer(torch.nn.Sequential):
    """Default network; a checkpoint builds it anew from its config."""


def hidden_layer(config: LearnerConfig, inputs: int, rng: np.random.Generator) -> HiddenLayer:
    """The default network: one hidden layer of tanh units, as in the earlier work (reference [19]).

    Args:
        config: Numbers of hidden and output units.
        inputs: Number of SOM units, k.
        rng: Draws the weights.
    """
    outputs = config.units[0] * config.units[1]
    first, second = torch.nn.Linear(inputs, config.hidden), torch.nn.Linear(config.hidden, outputs)
    with torch.no_grad():
        for layer, spread in ((first, 3.0), (second, 0.01)):
            layer.weight.copy_(torch.from_numpy(spread * rng.standard_normal(tuple(layer.weight.shape))))
            layer.bias.zero_()
    return HiddenLayer(first, torch.nn.Tanh(), second)


class NetworkLearner:
    """Online gradient descent on the squared error of the population's activity, with any network."""

    def __init__(self, config: LearnerConfig, network: torch.nn.Module):
        """Make a learner of ``network``, which maps (k,) to (pan units * tilt units,)."""
        self.config, self._code = config, PopulationCode(config)
        self._network = network
        self._descent = torch.optim.SGD(network.parameters(), lr=config.network_rate)

    def predict(self, face: np.ndarray) -> np.ndarray:
        """The command (2,), deg, whose units the activations (k,) make most active.

        Raises:
            ConfigError: The network has diverged.
        """
        return self._code.decode(self._activity(face))

    def score(self, face: np.ndarray, locations: Locations) -> np.ndarray:
        """Activity (n,) of the units about each of the n objects in view.

        Raises:
            ConfigError: The network has diverged.
        """
        return self._code.at(self._activity(face), locations_in_view(locations))

    def _activity(self, face: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            activity = self._network(torch.from_numpy(face).float())
        if not torch.isfinite(activity).all():
            raise ConfigError(f"the network diverged; choose a learner.network_rate below {self.config.network_rate}")
        units: np.ndarray = activity.double().numpy().reshape(self._code.shape)
        return units

    def learn(self, face: np.ndarray, locations: Locations) -> None:
        """Make one step of backpropagation towards the location reached, if one was."""
        if locations.reached is None:
            return
        wanted = torch.from_numpy(self._code.encode(locations.reached).ravel()).float()
        self._descent.zero_grad()
        (0.5 * (self._network(torch.from_numpy(face).float()) - wanted).square().sum()).backward()
        self._descent.step()

    def weights(self) -> np.ndarray:
        """All parameters, as one array."""
        return torch.nn.utils.parameters_to_vector(self._network.parameters()).detach().numpy().copy()

    def load(self, weights: np.ndarray) -> None:
        """Take over what ``weights`` gave.

        Raises:
            ConfigError: The network has another number of parameters, or they are not finite.
        """
        fitting = torch.from_numpy(same_shape(weights, self.weights()))
        torch.nn.utils.vector_to_parameters(fitting, self._network.parameters())

    def __getstate__(self) -> dict[str, Any]:
        """State for a checkpoint: config and parameters, for a checkpoint holds no classes of torch.

        Raises:
            ConfigError: The network is another one; a subclass that knows how to build it overrides both methods.
        """
        if not isinstance(self._network, HiddenLayer):
            raise ConfigError("a learner with a network of your own needs its own __getstate__ and __setstate__")
        inputs = next(self._network.parameters()).shape[1]
        return {"config": self.config, "inputs": inputs, "parameters": self.weights()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        config = state["config"]
        self.config, self._code = config, PopulationCode(config)
        self._network = hidden_layer(config, state["inputs"], np.random.default_rng(0))
        self._descent = torch.optim.SGD(self._network.parameters(), lr=config.network_rate)
        self.load(state["parameters"])
