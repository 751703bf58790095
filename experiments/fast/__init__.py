"""Chapter 7's first open problem: contingency in fewer turns, with a threshold that no world has to set."""
