"""Where people train and control: the arm's tasks, `reach`, `track`, `hold` and `grasp`, for dm_control and Gymnasium.

Everything that decides numbers (what an action means, what is drawn, seen and rewarded) is here once and works on
arrays with a leading axis of arms, so that one environment and a vector of them show the same bits, and dm_control's
the same numbers. The front ends are `gym`, `vector` and `dm`; each imports its library only itself.
"""
