"""Looks of an agent back over all its steps, now and then, between two of them.

At a look reactive modules that learn get new tables. With stop rule ``local`` maps are read anew, and an event may be
found.
"""

from collections.abc import Sequence

import numpy as np

from jointattn_mj.contingency.online.detector import NOTHING
from jointattn_mj.contingency.online.events import Event, Variables
from jointattn_mj.contingency.online.experience import Experience, PastSteps
from jointattn_mj.contingency.online.followed_maps import followed_map
from jointattn_mj.contingency.online.local import LocalConfig, search
from jointattn_mj.contingency.online.modules import OFFERS_NOTHING, Module
from jointattn_mj.guards.restored import check_whole


class Looks:
    """When to look, and what is found and read then.

    Attributes:
        next: Number of steps after which the next look is due.
        made_at: Steps done when each module was made.
    """

    def __init__(self, config: LocalConfig):
        """Looks of an agent before its first step.

        Args:
            config: Settings of stop rule local; when to look is among them.
        """
        self._config = config
        self.next = int(config.first_look)
        self.made_at: list[int] = []

    def postpone(self, n_steps: int) -> None:
        """Set the time of the next look.

        Args:
            n_steps: Steps done.
        """
        self.next = n_steps + max(self._config.look_every, int(n_steps * self._config.look_again))

    def steps(self, experience: Experience, n_steps: int, variables: Variables, modules: Sequence[Module]) -> PastSteps:
        """All steps so far, with what hindsight says of the use of modules.

        Args:
            experience: What was kept of them.
            n_steps: How many there are.
            variables: Of the agent.
            modules: Of the agent.
        """
        steps = PastSteps(experience, n_steps, variables)
        for number, module in enumerate(modules):
            if self._config.hindsight:
                steps.see_in_hindsight(number, module)
            else:
                steps.begins_at(number, self.made_at[number])
        return steps

    def followed(self, steps: PastSteps, modules: Sequence[Module]) -> list[Module]:
        """The modules with maps from all steps, each in the light of those before it.

        Args:
            steps: All steps; what they say of the use of modules is changed.
            modules: The modules as they were.
        """
        if self._config.maps == "frozen":
            return list(modules)
        read = list[Module]()
        for number, module in enumerate(modules):
            read.append(self.module(module.event, steps))
            if self._config.hindsight:
                steps.see_in_hindsight(number, read[-1])
        return read

    def module(self, event: Event, steps: PastSteps) -> Module:
        """The module of an event by the steps so far."""
        return followed_map(event, steps.of(event), steps.begin(event), self._config)

    def find(
        self, steps: PastSteps, events: Sequence[Event], modules: Sequence[Module], known: np.ndarray
    ) -> tuple[int, np.ndarray]:
        """Look for a contingent event.

        Args:
            steps: All steps.
            events: The E events that are ranked.
            modules: Modules that there are.
            known: (E,) whether each event was found before.

        Returns:
            Number of the event that is found, or NOTHING; and every event's value (E,), nats.
        """
        served = [module.event for module in modules]
        since = max(0, self.made_at[-1] - steps.forgotten) if self.made_at else 0
        if steps.n_steps < 2:
            return NOTHING, np.zeros(len(events))
        return search(steps, events, served, known, since, self._config, lambda event: self._offers(event, steps))

    def check(self, modules: int) -> None:
        """Refuse looks that an agent with so many modules cannot have.

        Raises:
            ValueError: They are none.
        """
        check_whole("next look", self.next, 1, np.iinfo(np.int64).max)
        if len(self.made_at) != modules:
            raise ValueError(f"an agent with {modules} modules made them at as many steps; got {len(self.made_at)}")
        for step in self.made_at:
            check_whole("step of a module", step, 0, np.iinfo(np.int64).max)

    def _offers(self, event: Event, steps: PastSteps) -> bool:
        """Whether the module of an event would offer anything."""
        return bool((self.module(event, steps).command != OFFERS_NOTHING).any())
