/* A user's control law: separates the boosters of hil/scenarios/boosters/scenario.yaml, and prints what happened.
 *   separate SCENARIO */
#include <stdio.h>

#include "unlatch.h"

static int give_up(const char* task) {
  const unlatch_error* error = unlatch_get_error(0);
  fprintf(stderr, "%s: %s\n", task, error != NULL ? error->text : "unknown error");
  return 1;
}

/* Index of a simulation's item by its name, or -1. */
static int find(unlatch_simulation* sim, int32_t kind, const char* name, int booster) {
  char full[32];
  size_t index = 0;
  snprintf(full, sizeof full, booster > 0 ? "%s%d" : "%s", name, booster);
  return unlatch_find(sim, kind, full, &index) == UNLATCH_OK ? (int)index : -1;
}

/* Sets the channels NAME1 to NAME4, or NAME if only that exists. */
static unlatch_status command(unlatch_simulation* sim, const char* name, double value) {
  unlatch_status status = UNLATCH_OK;
  int i;
  if (find(sim, UNLATCH_CHANNEL, name, 0) >= 0)
    return unlatch_set_channel(sim, (size_t)find(sim, UNLATCH_CHANNEL, name, 0), value);
  for (i = 1; i <= 4 && status == UNLATCH_OK; ++i)
    status = unlatch_set_channel(sim, (size_t)find(sim, UNLATCH_CHANNEL, name, i), value);
  return status;
}

int main(int argc, char** argv) {
  /* Commands by ticks of 1 ms; the nozzles follow 12 ms after the contact of their booster. */
  static const struct {
    int64_t tick;
    const char* channel;
    double value;
  } sequence[] = {{100, "throttle", 0.84}, {250, "verniers", 0}, {300, "rudder", 0}, {450, "cut_ties", 1}, {500, "cutoff", 1}};
  const size_t commands = sizeof sequence / sizeof sequence[0];
  unlatch_simulation* sim = NULL;
  unlatch_array sensors = {.size = sizeof sensors};
  const unlatch_event* events = NULL;
  int64_t tick, contact[5] = {-1, -1, -1, -1, -1};
  size_t count = 0, next = 0, i;
  uint64_t hash = 0;
  int booster, kr[5], nozzle[5];

  if (argc != 2) {
    fprintf(stderr, "usage: separate SCENARIO\n");
    return 2;
  }
  if (unlatch_load(argv[1], NULL, &sim) < 0) return give_up("loading");
  if (unlatch_get_array(sim, UNLATCH_SENSORS, 0, &sensors) < 0) return give_up("sensors");
  for (booster = 1; booster <= 4; ++booster) {
    unlatch_item item = {.size = sizeof item};
    const int sensor = find(sim, UNLATCH_SENSOR, "kr", booster);
    nozzle[booster] = find(sim, UNLATCH_CHANNEL, "nozzle", booster);
    if (sensor < 0 || nozzle[booster] < 0) return give_up("names");
    if (unlatch_describe(sim, UNLATCH_SENSOR, (size_t)sensor, &item) < 0) return give_up("names");
    kr[booster] = item.first;
  }
  for (tick = 0; tick < 2000; ++tick) {
    for (; next < commands && sequence[next].tick == tick; ++next) {
      if (command(sim, sequence[next].channel, sequence[next].value) < 0) return give_up("commanding");
    }
    for (booster = 1; booster <= 4; ++booster) {
      /* The sensors' numbers keep their addresses, and have the values of this tick. */
      if (contact[booster] < 0 && unlatch_get_number(&sensors, (size_t)kr[booster], 0) > 0.5) contact[booster] = tick;
      if (contact[booster] >= 0 && tick == contact[booster] + 12 &&
          unlatch_set_channel(sim, (size_t)nozzle[booster], 1) < 0)
        return give_up("commanding");
    }
    if (unlatch_step(sim) < 0) return give_up("stepping");
  }
  if (unlatch_get_events(sim, &events, &count, NULL) < 0) return give_up("events");
  for (i = 0; i < count; ++i) {
    unlatch_item item = {.size = sizeof item};
    if (unlatch_describe(sim, UNLATCH_EVENT_KIND, (size_t)events[i].event, &item) < 0) return give_up("events");
    printf("%.6f s  %s %s\n", events[i].time, item.name, item.text);
  }
  if (unlatch_get_hash(sim, &hash) < 0) return give_up("hash");
  printf("hash %016llx\n", (unsigned long long)hash);
  return unlatch_close(sim) == UNLATCH_OK ? 0 : 1;
}
