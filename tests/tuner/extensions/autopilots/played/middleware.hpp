// What the played checkout asks of its middleware: nothing but the bench.
#pragma once

#include "protocol.hpp"
