"""Which measures find the right event of chapter 4, and after how many steps: what section 4.6 leaves open."""
