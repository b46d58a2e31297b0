#include "bridge/target/separation.h"

static const int64_t kMs = 1000000; /* ns */

/* The cyclogram, from the separation command at t = 0: channels, each of all boosters, and what they are set to. */
static const struct {
  int64_t at_ms;
  const char* channel;
  double value;
} kCyclogram[] = {
    {100, "throttle", 0.84}, {250, "verniers", 0}, {300, "rudder", 0}, {450, "cut_ties", 1}, {500, "cutoff", 1}};
enum { kSteps = sizeof kCyclogram / sizeof kCyclogram[0] };
static const int64_t kNozzleDelay_ms = 12; /* from a booster's contact to its nozzle */
static const double kClosed = 0.5;         /* a contact that reads more has fired */

/* "throttle", 2: the number of "throttle2"; 0: of the name alone. */
static int find(const unlatch_participant* p, int kind, const char* name, int booster) {
  char whole[UNLATCH_WIRE_NAME_LENGTH];
  size_t length = strlen(name);
  memcpy(whole, name, length);
  if (booster > 0) whole[length++] = (char)('0' + booster);
  whole[length] = 0;
  return unlatch_participant_find(p, kind, whole);
}

/* Scenarios have one channel for all boosters, or one for each: a command goes to those that there are. */
static void command(unlatch_participant* p, const char* name, int booster, double value) {
  const int channel = find(p, UNLATCH_CATALOG_KIND_CHANNEL, name, booster);
  if (channel >= 0) (void)unlatch_participant_command(p, channel, value);
}

void unlatch_separation_begin(unlatch_separation* sequence) {
  int i;
  memset(sequence, 0, sizeof *sequence);
  for (i = 0; i < UNLATCH_SEPARATION_BOOSTERS; ++i) sequence->contact_ns[i] = -1;
}

void unlatch_separation_update(unlatch_separation* sequence, unlatch_participant* p) {
  const int64_t now_ns = p->state.time_ns;
  int i, count = 0;
  while (count < UNLATCH_SEPARATION_BOOSTERS && find(p, UNLATCH_CATALOG_KIND_CHANNEL, "nozzle", count + 1) >= 0)
    ++count;
  for (; sequence->steps < kSteps && now_ns >= kCyclogram[sequence->steps].at_ms * kMs; ++sequence->steps) {
    command(p, kCyclogram[sequence->steps].channel, 0, kCyclogram[sequence->steps].value);
    for (i = 1; i <= count; ++i) command(p, kCyclogram[sequence->steps].channel, i, kCyclogram[sequence->steps].value);
  }
  for (i = 0; i < count; ++i) {
    const int contact = find(p, UNLATCH_CATALOG_KIND_SENSOR, "kr", i + 1);
    if (contact < 0 || contact >= p->state.sensor_count) continue;
    if (sequence->contact_ns[i] < 0 && p->state.sensors[contact] > kClosed) sequence->contact_ns[i] = now_ns;
    if (sequence->contact_ns[i] < 0 || sequence->is_open[i] || now_ns < sequence->contact_ns[i] + kNozzleDelay_ms * kMs)
      continue;
    command(p, "nozzle", i + 1, 1);
    sequence->is_open[i] = 1;
  }
}
