"""The mechanism of chapter 5 in real time: nobody waits for anybody, and attention decides when a step has happened."""
