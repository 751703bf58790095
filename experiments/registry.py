"""Every claim under its id. A claim is one entry here and one folder beside this file:

``sweep.py`` has ``SETTINGS`` and ``cell`` (and ``FIRST_SEED`` or ``VERSION`` where they are not 0 and 1), and
``analysis.py`` has ``analyse`` and ``draw``. Nothing of them is imported before the claim is asked for.
"""

from jointattn_mj.laboratory.registry import Entry, Registry  # noqa: F401

REGISTRY = Registry(
    "experiments",
    # Entry("5.2", "order", "title", "section 5.3.2, Fig. 5.3", "What the dissertation says."),
)
