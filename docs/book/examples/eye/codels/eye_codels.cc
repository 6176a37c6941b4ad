#include <algorithm>

#include "eye_cxx_types.h"

// Task look begins: nothing was measured yet.
genom::event
eye_begin(std::vector<double> &recent)
{
  recent.clear();
  return eye::look;
}

// Each period: the median, which a wrong reading or two do not change.
genom::event
eye_look(const std::vector<double> &recent, eye::width &width)
{
  std::vector<double> sorted(recent);
  std::sort(sorted.begin(), sorted.end());
  width.data() = sorted.empty() ? 0. : sorted[sorted.size() / 2];
  width.write();
  return eye::pause::look;
}

// Function measure: keeps the last five readings.
genom::event
eye_measure(double reading, std::vector<double> &recent)
{
  recent.push_back(reading);
  if (recent.size() > 5) recent.erase(recent.begin());
  return genom::ok;
}
