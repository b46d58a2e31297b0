#include "hil/study/optimize/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "hil/scenario/base/module.h"
#include "hil/study/optimize/confirmation.h"
#include "hil/study/optimize/scaled_space.h"
#include "hil/study/optimize/study.h"
#include "hil/study/sampling/sampling.h"

namespace unlatch::hil {
namespace {

constexpr double kForCoarse = 0.25;   // part of the budget's seconds, for a first search with few samples
constexpr double kForPolish = 0.25;   // part of the budget, after a global search
constexpr double kForFeasible = 0.5;  // part of the remaining budget, for a phase that searches a first feasible point
constexpr double kAgainst = 0.99;     // relative to the largest violation: such constraints limit it together

class Search {
 public:
  Search(const OptimizeProblem& problem, OptimizeEvaluations& evaluations)
      : problem_(problem), evaluations_(evaluations), merit_(start()), none_(problem.constraints.size(), 0.0) {}

  OptimizeResult run(bool study, const std::function<void(const OptimizePoint&)>& found) {
    if (!evaluations_.get_samples().empty() && !look_coarsely()) look();
    result_.search_runs = evaluations_.get_runs();
    if (evaluations_.was_stopped())
      result_.end = OptimizeResult::End::kStopped;
    else if (cut_)
      result_.end = OptimizeResult::End::kBudget;
    if (evaluations_.get_samples().empty()) return result_;
    take_best();
    confirm(found);
    check_front();
    result_.late = evaluations_.is_late();
    result_.search_count = search_count_;
    if (study && !evaluations_.was_stopped()) study_result(problem_, evaluations_, merit_, result_);
    if (!evaluations_.was_stopped()) evaluations_.finish_journal();
    return result_;
  }

 private:
  // Flies the result with fresh samples. Where they do not confirm the search's verdict, or leave room at its limits,
  // it goes on from there with the next demand, and as many runs again. The best of the results that they confirm
  // stays; if there is none, one that is neither confirmed nor refuted stays if the next search finds none.
  void confirm(const std::function<void(const OptimizePoint&)>& found) {
    if (!has_probabilities(problem_)) return;
    result_.flights = evaluations_.get_demand().flights;
    std::optional<OptimizeResult> kept;  // the best confirmed one, or else the last one that may be
    OptimizeDemand kept_demand;
    bool hopes = false;  // the last search asked for less than what fresh samples surely confirm
    for (std::uint64_t round = 0; !evaluations_.was_stopped(); ++round) {
      const OptimizePoint best = get_result_sample().point;
      found(best);
      result_.check = evaluations_.check_dispersed(best, round, list_rooms());
      if (!result_.check || problem_.objectives.size() > 1) break;
      const std::vector<std::size_t> against = result_.against;
      const bool denied = !against.empty() && is_denied_by_search_alone(problem_, get_result_sample(), *result_.check);
      if (denied) {
        result_.feasible = result_.has_room = true;
        result_.violation = {};
        result_.against.clear();
      } else {
        result_.has_room = has_room();
      }
      if (!kept || is_rather(result_, *kept)) {
        kept = result_;
        kept_demand = evaluations_.get_demand();
      } else if (!result_.feasible || is_confirmed(result_)) {
        break;  // with this demand there is nothing, or nothing better
      }
      if (evaluations_.is_late() || round >= kRounds) break;
      if (!result_.feasible && against.empty()) break;  // a result is missing, no constraint
      const std::optional<double> room = is_confirmed(result_) ? find_room() : std::nullopt;
      // A search that asks for less than what is surely confirmed is made once from each result.
      if (hopes && !is_confirmed(result_)) break;
      hopes = room && *room < kSure;
      const std::optional<OptimizeDemand> next =
          choose_demand(problem_, evaluations_, get_result_sample(), against, room, *result_.check);
      if (!next) break;
      const OptimizeDemand now = evaluations_.get_demand();
      evaluations_.set_demand(*next);
      if (!search_again(best)) {
        evaluations_.set_demand(now);
        break;
      }
      take_best();
    }
    if (kept && problem_.objectives.size() == 1) {
      const std::int64_t runs = evaluations_.get_runs();
      if (!result_.check || !is_rather(result_, *kept)) {
        result_ = *kept;
        result_.search_runs = runs;
        evaluations_.set_demand(kept_demand);
      }
      if (evaluations_.was_stopped()) result_.end = OptimizeResult::End::kStopped;
    }
    if (evaluations_.was_stopped()) return;
    describe_margins();
  }

  [[nodiscard]] const OptimizeSample& get_result_sample() const { return evaluations_.get_samples()[result_.best]; }
  [[nodiscard]] static bool is_confirmed(const OptimizeResult& result) {
    return result.feasible && result.check && !result.check->has(DispersedCheck::Verdict::kOpen) &&
           !result.check->has(DispersedCheck::Verdict::kRefuted);
  }
  // Returns true if a later result replaces another: it is confirmed and better, or the other may not stand.
  [[nodiscard]] bool is_rather(const OptimizeResult& later, const OptimizeResult& other) const {
    const auto get = [&](const OptimizeResult& result) -> const OptimizeSample& {
      return evaluations_.get_samples()[result.best];
    };
    if (is_confirmed(other)) {
      const double now = merit_.scale(get(later)).objectives[0], before = merit_.scale(get(other)).objectives[0];
      const bool is_surer = other.has_room && !later.has_room;  // the same, and nothing better was left beside it
      return is_confirmed(later) && (now < before || (now == before && is_surer));
    }
    const bool may_stand = other.feasible && !other.check->has(DispersedCheck::Verdict::kRefuted);
    return later.feasible || !may_stand;
  }

  // A limit with a probability ends the search: there is nothing better on its other side.
  [[nodiscard]] bool is_at_limit(std::size_t constraint) const {
    return problem_.constraints[constraint].probability > 0 && !list_continuous(problem_).empty() && result_.feasible &&
           get_result_sample().margins[constraint] <= kAtLimit * merit_.constraint_scale(constraint);
  }
  [[nodiscard]] std::vector<double> list_rooms() const {
    std::vector<double> rooms;
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i)
      rooms.push_back(is_at_limit(i) ? kRoom * merit_.constraint_scale(i) : HUGE_VAL);
    return rooms;
  }
  // Fresh samples leave room at the wanted probability.
  [[nodiscard]] bool has_room() const {
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i)
      if (is_at_limit(i) && is_confirmed(result_) &&
          result_.check->constraints[i].margin.margin > kRoom * merit_.constraint_scale(i))
        return true;
    return false;
  }
  // They leave room that a better design may use and be confirmed: with how many deviations, the surest first.
  [[nodiscard]] std::optional<double> find_room() const {
    for (const double deviations : {kSure, 1.0, 0.0})
      for (std::size_t i = 0; i < problem_.constraints.size(); ++i)
        if (is_at_limit(i) &&
            calc_room(problem_, i, *result_.check, deviations) > kWorthARoom * merit_.constraint_scale(i))
          return deviations;
    return std::nullopt;
  }

  // By the samples of the search where no others were flown, at the wanted probabilities all the same.
  void describe_margins() {
    result_.margins.assign(problem_.constraints.size(), std::nullopt);
    const auto flown = result_.check
                           ? std::nullopt
                           : evaluations_.fly_margins(get_result_sample().point, evaluations_.get_demand().flights);
    if (!result_.check && !flown) return;
    for (std::size_t i = 0; i < problem_.constraints.size(); ++i) {
      const double probability = problem_.constraints[i].probability;
      if (!(probability > 0)) continue;
      result_.margins[i] =
          result_.check ? result_.check->constraints[i].margin : describe_margin((*flown)[i], probability);
    }
  }

  // Flies each point of a front with fresh samples, until the budget's seconds are over.
  void check_front() {
    if (!has_probabilities(problem_)) return;
    for (std::size_t i = 0; i < result_.front.size(); ++i) {
      const std::size_t sample = result_.front[i];
      std::optional<DispersedCheck>& check = result_.front_checks.emplace_back();
      if (sample == result_.best)
        check = result_.check;
      else if (!evaluations_.was_stopped() && !evaluations_.is_late())
        check = evaluations_.check_once(evaluations_.get_samples()[sample].point, kRounds + 1 + i);
    }
  }

  // Searches around a point with another demand. False: not even that point was flown.
  bool search_again(const OptimizePoint& from) {
    end_ = evaluations_.get_runs() + problem_.budget.runs;
    evaluations_.set_limit(end_);
    std::vector<std::int64_t> first;
    if (!evaluations_.evaluate({from}, first)) return false;
    ++search_count_;
    result_.flights = evaluations_.get_demand().flights;
    result_.check.reset();
    whole_ = {evaluations_.get_samples().size(), static_cast<std::size_t>(first[0])};
    least_violation_ = HUGE_VAL;
    cut_ = false;
    if (!try_all()) search_local(from, true);
    result_.search_runs = evaluations_.get_runs();
    result_.end = evaluations_.was_stopped() ? OptimizeResult::End::kStopped
                  : cut_                     ? OptimizeResult::End::kBudget
                                             : OptimizeResult::End::kConverged;
    return true;
  }

  // Evaluates the first sample, whose values are the scales, whatever the deadline.
  OptimizeMerit start() {
    evaluations_.set_limit(problem_.budget.runs);
    std::vector<std::int64_t> first;
    cut_ = !evaluations_.evaluate({get_start(problem_)}, first);
    evaluations_.set_deadline(problem_.budget.seconds);
    return OptimizeMerit(problem_, cut_ ? nullptr : &evaluations_.get_samples().front());
  }

  // Searches with an eighth of the samples first, and from its best point with all of them, with as many runs again:
  // most runs of a search are far from the limits, where few samples place them as well. False: it is not worth it.
  bool look_coarsely() {
    const OptimizeDemand demand = evaluations_.get_demand();
    const std::int64_t flights = choose_coarse(problem_, demand);
    if (flights == 0 || problem_.objectives.size() > 1 || list_continuous(problem_).empty() || cut_) return false;
    evaluations_.set_demand({flights, demand.parts});
    std::vector<std::int64_t> first;
    const bool flown = evaluations_.evaluate({get_start(problem_)}, first);
    const double seconds = problem_.budget.seconds;
    if (flown) {
      whole_ = {evaluations_.get_samples().size(), static_cast<std::size_t>(first[0])};
      evaluations_.set_deadline(kForCoarse * seconds);
      look();
    }
    evaluations_.set_deadline((1 - kForCoarse) * seconds);
    const OptimizePoint from = get_best().point;
    evaluations_.set_demand(demand);
    if (!flown || evaluations_.was_stopped() || !search_again(from)) {
      if (flown) evaluations_.set_demand({flights, demand.parts});
      cut_ = true;
    }
    return true;
  }

  void look() {
    const bool several = problem_.objectives.size() > 1, automatic = problem_.method == SearchMethod::kAuto;
    const bool catalogue = list_continuous(problem_).size() < problem_.variables.size();
    result_.method = several ? SearchMethod::kPareto : problem_.method;
    if (try_all()) return;
    if (several) return search_pareto();
    if (problem_.method == SearchMethod::kGlobal || (automatic && catalogue)) return search_global();
    result_.method = SearchMethod::kLocal;
    search_from_starts(!automatic);
    if (automatic && !is_feasible(get_best()) && !is_spent()) search_global();
  }

  // Searches from the problem's start, then from others within the bounds. Each has an equal part of the runs that are
  // left, as has a last search from the best point, if the one that has found it was cut. The end is that of the search
  // that has found the best.
  void search_from_starts(bool last) {
    std::vector<OptimizePoint> starts{get_start(problem_)};
    if (problem_.starts > 1) add_starts(starts);
    bool cut = false;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      const std::size_t parts = starts.size() - i + (starts.size() > 1 ? 1 : 0), best = update(whole_);
      end_ =
          evaluations_.get_runs() + (problem_.budget.runs - evaluations_.get_runs()) / static_cast<std::int64_t>(parts);
      search_local(starts[i], last);
      if (i == 0 || update(whole_) != best) cut = cut_;
    }
    end_ = problem_.budget.runs;
    if (starts.size() > 1 && cut && is_feasible(get_best()) && !is_spent()) {
      search_local(get_best().point, last);
      cut = cut_;
    }
    cut_ = cut || evaluations_.was_stopped() || evaluations_.is_late();
  }

  // Adds the best points of a Latin hypercube, none near another (Rinnooy Kan and Timmer 1987).
  void add_starts(std::vector<OptimizePoint>& starts) {
    const std::size_t n = problem_.variables.size();
    const auto wanted = static_cast<std::size_t>(problem_.starts);
    SamplingPlan plan;
    plan.sampling = Sampling::kLatinHypercube;
    plan.seed = problem_.seed;
    plan.samples = std::min(kTriedEach * (problem_.starts - 1), problem_.budget.runs / 4);
    plan.dimensions = n;
    const double apart = kApart * std::pow(static_cast<double>(plan.samples), -1.0 / static_cast<double>(n));
    std::vector<std::vector<double>> units;
    std::vector<OptimizePoint> points;
    for (std::int64_t i = 0; i < plan.samples; ++i) {
      units.push_back(calc_point(plan, i));
      points.emplace_back();
      for (std::size_t k = 0; k < n; ++k) points.back().push_back(place(problem_.variables[k], units.back()[k]));
    }
    std::vector<std::int64_t> indices;
    cut_ = !evaluations_.evaluate(points, indices);
    if (cut_) return;
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto get = [&](std::size_t i) { return evaluations_.get_samples()[static_cast<std::size_t>(indices[i])]; };
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return merit_.is_better(get(a), get(b)); });
    std::vector<std::size_t> chosen;
    for (const std::size_t i : order) {
      if (starts.size() == wanted) break;
      const auto is_near = [&](std::size_t other) {
        double distance = 0;
        for (std::size_t k = 0; k < n; ++k) distance = std::max(distance, std::abs(units[i][k] - units[other][k]));
        return distance < apart;
      };
      if (std::ranges::any_of(chosen, is_near)) continue;
      chosen.push_back(i);
      starts.push_back(points[i]);
    }
  }

  // Tries all combinations, if there are only catalogues and the budget is large enough.
  bool try_all() {
    if (!list_continuous(problem_).empty()) return false;
    double count = 1;
    for (const OptimizeVariable& variable : problem_.variables) count *= static_cast<double>(variable.catalogue.size());
    if (count > static_cast<double>(problem_.budget.runs)) return false;
    std::vector<OptimizePoint> points{OptimizePoint(problem_.variables.size(), 0.0)};
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      std::vector<OptimizePoint> more;
      for (const OptimizePoint& point : points)
        for (std::size_t k = 0; k < problem_.variables[i].catalogue.size(); ++k) {
          more.push_back(point);
          more.back()[i] = static_cast<double>(k);
        }
      points = std::move(more);
    }
    std::vector<std::int64_t> indices;
    for (std::size_t at = 0; at < points.size() && !cut_; at += kBatch) {
      const auto begin = points.begin() + static_cast<std::ptrdiff_t>(at);
      const std::vector<OptimizePoint> batch(
          begin, points.begin() + static_cast<std::ptrdiff_t>(std::min(points.size(), at + kBatch)));
      cut_ = !evaluations_.evaluate(batch, indices);
    }
    if (result_.method == SearchMethod::kAuto) result_.method = SearchMethod::kGlobal;
    result_.exhaustive = !cut_;
    return true;
  }

  // Searches the continuous variables around `from`, with its catalogue entries. From a point that misses constraints:
  // the problem itself; then the least violation, until a point meets all; then the problem from there. The first two
  // have a part of the budget each, so that neither uses all of it. `last`: no other search follows; the least
  // violation may use all that is left.
  void search_local(const OptimizePoint& from, bool last) {
    if (list_continuous(problem_).empty() || is_spent()) return;
    begin_phase(1);
    std::vector<std::int64_t> first;
    cut_ = !evaluations_.evaluate({from}, first);
    if (cut_) return;
    own_ = {evaluations_.get_samples().size(), static_cast<std::size_t>(first[0])};
    search_phases(from, last);
    result_.searches.push_back({static_cast<std::size_t>(first[0]), update(own_)});
  }

  void search_phases(const OptimizePoint& from, bool last) {
    const bool lost = !is_feasible();
    search_problem(from, lost ? kForFeasible : 1);
    if (!lost || is_spent()) return;
    if (is_feasible()) {
      if (cut_) search_problem(get_own().point, 1);
      return;
    }
    search_least_violation(get_own().point, kForFeasible);
    if (last && cut_ && !is_feasible() && !is_spent()) search_least_violation(get_own().point, 1);
    if (is_feasible() && !is_spent()) search_problem(get_own().point, 1);
  }

  // `share`: part of the remaining runs.
  void begin_phase(double share) {
    const double left = static_cast<double>(end_ - evaluations_.get_runs());
    evaluations_.set_limit(evaluations_.get_runs() + static_cast<std::int64_t>(std::ceil(share * left)));
    cut_ = false;
  }

  void search_problem(const OptimizePoint& from, double share) {
    begin_phase(share);
    if (!find_local()(prepare(list_continuous(problem_), from))) cut_ = true;
  }

  // Searches the least t that no violation exceeds.
  void search_least_violation(const OptimizePoint& from, double share) {
    begin_phase(share);
    ScaledProblem least = prepare(list_continuous(problem_), from);
    ++least.variables;
    least.impatient = true;
    least.start.push_back(std::clamp(merit_.calc_violation(get_own()).size / kLargest + kLeastTarget, 0.0, 1.0));
    const auto evaluate = least.evaluate;
    least.evaluate = [&](const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
      if (is_feasible()) return false;  // found: the next phase begins here
      std::vector<std::vector<double>> real = points;
      for (std::vector<double>& point : real) point.pop_back();
      if (!evaluate(real, samples)) return false;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double t = points[i].back() - kLeastTarget;
        samples[i].objectives = {t};
        for (double& constraint : samples[i].constraints) constraint = constraint / kLargest - t;
      }
      return true;
    };
    if (find_local()(least)) {
      least_violation_ = std::min(least_violation_, merit_.calc_violation(get_own()).size);
    } else if (!is_feasible()) {
      cut_ = true;
    }
  }

  void search_global() {
    result_.method = SearchMethod::kGlobal;
    const bool polish = !list_continuous(problem_).empty();
    const auto left = static_cast<double>(problem_.budget.runs - evaluations_.get_runs());
    evolve("unlatch_search_global", kColony + kColonyEach * problem_.variables.size(),
           evaluations_.get_runs() + static_cast<std::int64_t>((polish ? 1 - kForPolish : 1) * left));
    if (polish) search_local(get_best().point, true);
  }

  // Searches a front. As long as no point meets all constraints, the last part of the budget is for the least
  // violation: a population does not converge to it.
  void search_pareto() {
    const bool polish = !list_continuous(problem_).empty();
    const auto runs = static_cast<double>(problem_.budget.runs);
    const auto evolved = static_cast<std::int64_t>((polish ? 1 - kForPolish : 1) * runs);
    evolve("unlatch_search_pareto", kParetoSize, problem_.objectives.size() == 2 ? evolved : problem_.budget.runs,
           evolved);
    if (!polish || is_spent()) return;
    if (is_feasible()) return fill_gaps();
    search_least_violation(get_best().point, 1);
    if (is_feasible()) cut_ = true;  // the front is of that one point
  }

  // Fills the widest gaps of a front of two objectives by local searches: the best first objective with which the
  // second is in the middle of the gap, or better (epsilon constraints; Haimes et al. 1971).
  void fill_gaps() {
    if (problem_.objectives.size() != 2) return;
    const auto each = static_cast<std::int64_t>(kGapEach * (problem_.variables.size() + 1));
    std::set<std::pair<std::size_t, std::size_t>> tried;
    while (!is_spent()) {
      const std::optional<Gap> gap = find_gap(tried);
      if (!gap) break;
      tried.insert({gap->from, gap->to});
      const OptimizeSample& from = evaluations_.get_samples()[gap->to];  // meets the limit of the second objective
      ScaledProblem one = prepare(list_continuous(problem_), from.point);
      one.objectives = 1;
      ++one.constraints;
      one.impatient = true;
      const auto evaluate = one.evaluate;
      one.evaluate = [&](const std::vector<std::vector<double>>& points, std::vector<ScaledSample>& samples) {
        if (!evaluate(points, samples)) return false;
        for (ScaledSample& sample : samples) {
          sample.constraints.push_back(sample.objectives[1] - gap->second);
          sample.objectives.pop_back();
        }
        return true;
      };
      evaluations_.set_limit(std::min(problem_.budget.runs, evaluations_.get_runs() + each));
      find_local()(one);
    }
    cut_ = true;
  }

  // Two neighbours of a front, by the first objective, and the middle of their second objectives, scaled.
  struct Gap {
    std::size_t from = 0, to = 0;
    double second = 0;
  };
  [[nodiscard]] std::optional<Gap> find_gap(const std::set<std::pair<std::size_t, std::size_t>>& tried) const {
    const std::vector<OptimizeSample>& samples = evaluations_.get_samples();
    const std::vector<std::size_t> front = merit_.find_front(samples);
    if (front.size() < 2) return std::nullopt;
    const auto get = [&](std::size_t i, std::size_t k) { return merit_.scale(samples[front[i]]).objectives[k]; };
    const std::size_t last = front.size() - 1;
    const double first_range = get(last, 0) - get(0, 0), second_range = get(0, 1) - get(last, 1);
    std::optional<Gap> widest;
    double width = 0;
    for (std::size_t i = 0; i < last; ++i) {
      const double one =
          std::max((get(i + 1, 0) - get(i, 0)) / first_range, (get(i, 1) - get(i + 1, 1)) / second_range);
      if (one <= width || tried.count({front[i], front[i + 1]}) != 0) continue;
      width = one;
      widest = {front[i], front[i + 1], 0.5 * (get(i, 1) + get(i + 1, 1))};
    }
    return widest;
  }

  // Evolves a population. Repeated points cost nothing, so there may be more generations than the budget has runs for.
  // `hopeless`: number of runs after which it ends if no point meets all constraints.
  void evolve(const char* function, std::size_t population, std::int64_t limit,
              std::int64_t hopeless = std::numeric_limits<std::int64_t>::max()) {
    std::vector<std::size_t> list(problem_.variables.size());
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = i;
    ScaledProblem scaled = prepare(list, get_start(problem_));
    scaled.population = (population + 3) / 4 * 4;
    scaled.generations = 2 * static_cast<std::size_t>(problem_.budget.runs) / scaled.population + 1;
    evaluations_.set_limit(std::max(evaluations_.get_runs(), limit));
    cut_ = false;
    scaled.evaluate = [this, hopeless, evaluate = scaled.evaluate](const std::vector<std::vector<double>>& points,
                                                                   std::vector<ScaledSample>& samples) {
      if (evaluations_.get_runs() < hopeless || is_feasible()) return evaluate(points, samples);
      cut_ = true;
      return false;
    };
    find_function<GlobalSearch>(kOptimizersModule, function)(scaled);
  }

  ScaledProblem prepare(std::vector<std::size_t> list, OptimizePoint base) {
    ScaledProblem scaled = make_scaled(problem_, evaluations_, merit_, std::move(list), std::move(base), none_);
    scaled.evaluate = [this, evaluate = scaled.evaluate](const std::vector<std::vector<double>>& points,
                                                         std::vector<ScaledSample>& samples) {
      if (evaluate(points, samples)) return true;
      cut_ = true;
      return false;
    };
    return scaled;
  }

  static LocalSearch* find_local() { return find_function<LocalSearch>(kOptimizersModule, "unlatch_search_local"); }

  // Returns true if the budget has ended the search before the next phase.
  bool is_spent() {
    const bool spent = evaluations_.was_stopped() || evaluations_.is_late() || evaluations_.get_runs() >= end_;
    cut_ = cut_ || spent;
    return spent;
  }
  // Best of the samples from some on; each is compared once.
  struct Best {
    std::size_t seen = 0, best = 0;
  };
  std::size_t update(Best& one) const {
    const std::vector<OptimizeSample>& samples = evaluations_.get_samples();
    for (; one.seen < samples.size(); ++one.seen)
      if (merit_.is_better(samples[one.seen], samples[one.best])) one.best = one.seen;
    return one.best;
  }
  const OptimizeSample& get_best() { return evaluations_.get_samples()[update(whole_)]; }
  const OptimizeSample& get_own() { return evaluations_.get_samples()[update(own_)]; }
  [[nodiscard]] bool is_feasible() { return is_feasible(get_own()); }
  [[nodiscard]] bool is_feasible(const OptimizeSample& sample) const { return merit_.is_feasible(sample); }

  void take_best() {
    const OptimizeSample& best = get_best();
    result_.best = whole_.best;
    result_.against.clear();
    result_.violation = merit_.calc_violation(best);
    result_.feasible = result_.violation.size == 0;
    result_.settled = result_.exhaustive || result_.violation.size >= kAgainst * least_violation_;
    for (std::size_t i = 0; i < problem_.constraints.size() && !result_.feasible; ++i)
      if (merit_.calc_violation(best, i) >= kAgainst * result_.violation.size) result_.against.push_back(i);
    if (problem_.objectives.size() == 1 || !result_.feasible) return;
    result_.front = merit_.find_front(evaluations_.get_samples());
    result_.best = merit_.find_middle(evaluations_.get_samples(), result_.front);
  }

  static constexpr std::uint64_t kRounds = 8;     // of other demands, at most
  static constexpr double kWorthARoom = 0.01;     // relative to the limit: so much is worth another search
  static constexpr double kAtLimit = 0.01;        // relative to the limit
  static constexpr double kLargest = 10;          // largest violation in the range of t
  static constexpr double kLeastTarget = 0.1;     // t may fall below 0, when all are met
  static constexpr std::int64_t kTriedEach = 10;  // points of which one becomes a start
  static constexpr std::size_t kGapEach = 12;     // runs of a gap, for each variable and one more
  static constexpr double kApart = 0.5;           // of the mean distance of the points tried
  static constexpr std::size_t kBatch = 64, kParetoSize = 40, kColony = 16, kColonyEach = 4;

  const OptimizeProblem& problem_;
  OptimizeEvaluations& evaluations_;
  bool cut_ = false;  // the limit ended the last phase
  const OptimizeMerit merit_;
  const std::vector<double> none_;
  OptimizeResult result_;
  Best whole_, own_;                         // of all samples, and of the local search
  std::int64_t end_ = problem_.budget.runs;  // number of runs at which the local search ends
  std::int64_t search_count_ = 1;
  double least_violation_ = HUGE_VAL;  // result of a search of the least violation that has converged
};

}  // namespace

OptimizeResult search_optimum(const OptimizeProblem& problem, OptimizeEvaluations& evaluations, bool study,
                              const std::function<void(const OptimizePoint&)>& found) {
  return Search(problem, evaluations).run(study, found);
}

}  // namespace unlatch::hil
