"""Harnesses that kill, feed nonsense to, and run for a day what the package promises to survive.

    python -m tools.reliability kills       kill -9 at random moments
    python -m tools.reliability pairs       two commands at once in one folder
    python -m tools.reliability malformed   options, files and Python calls that make no sense
    python -m tools.reliability hours       a simulated day: memory over time, bytes written
    python -m tools.reliability report      their figures into docs/reliability.md

Each prints what it found and leaves it as JSON in ``experiments/reliability``.
"""
