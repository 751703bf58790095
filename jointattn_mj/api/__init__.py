"""What Python users call: one file a job, named like its command in ``jointattn_mj.cli``.

``import jointattn_mj`` offers these names at the top.
"""
