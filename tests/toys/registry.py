"""Two claims: one about coins, and one whose analysis fails."""

from jointattn_mj.sweeps.registry import Entry, Registry

REGISTRY = Registry(
    "toys",
    Entry("1.1", "coin", "Coins & <luck>", "section 1, Fig. 1.1", "A fair coin shows heads half of the time."),
    Entry("1.2", "broken", "A claim that cannot be read", "section 1.2", "Nothing."),
)
