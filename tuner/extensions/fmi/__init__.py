"""The controller as a Functional Mock-up Unit: for Simulink, Dymola, OpenModelica and other importers of FMI 2.0."""
