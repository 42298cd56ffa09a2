"""Design before search: gains from requirements on the linear loops, one algorithm a file. See `cascade_design` for its use."""

from objectives.design.cascade_design import DESIGNERS, design, design_axes
from objectives.design.design_axis import AxisDesign, DesignAxis
from objectives.design.requirements import DesignRequirements

__all__ = ["DESIGNERS", "AxisDesign", "DesignAxis", "DesignRequirements", "design", "design_axes"]
