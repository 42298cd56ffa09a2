"""The controller as a Functional Mock-up Unit for Simulink, Dymola, OpenModelica and every other importer of FMI 2.0."""
