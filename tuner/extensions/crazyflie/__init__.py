"""Crazyflie: parameters of its own PID cascade, or an out-of-tree controller that flies any law."""
