// Total error against time.
#include "experiments/studies/frames/frames.hpp"
