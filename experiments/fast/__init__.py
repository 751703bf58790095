"""Chapter 7's first open problem: contingency in fewer steps, with a threshold that no world has to set."""
