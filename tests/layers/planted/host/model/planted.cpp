// A planted fault: the layer check must find it.
#include "fit/layers.h"
