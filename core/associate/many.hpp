// Many targets from plots without identity: the life cycle of Bernoulli tracks with Poisson births.
//
// Track-oriented marginal MeMBer/Poisson filter. Williams, IEEE Trans. AES 51(3), 2015. The equations are in docs/many-targets.md.
#pragma once

#include <memory>
#include <string>

#include "associate/decide.hpp"
#include "associate/scanner.hpp"

namespace jink::inline JINK_LEVEL {

// Of one sensor: what it sees of what is there, and what it sees that is not.
struct SensorView {
    double detection = 0.9;
    double clutter = 1e-8;     // per unit of area (or volume) and scan
    double undetected = 0.0;   // targets that nobody has seen yet, per unit of area
    double arrivals = 0.0;     // new ones per unit of area and second
    double low[2] = {-INFINITY, -INFINITY}, high[2] = {INFINITY, INFINITY};
    double site[2] = {0.0, 0.0}, reach = INFINITY;
    double area = 1.0;
    bool scanning = true;      // it looks everywhere in each scan, so that no plot is a miss
    bool learning = true;      // the clutter density
    int scans = 0;

    bool sees(double x, double y) const {
        const double dx = x - site[0], dy = y - site[1];
        return x >= low[0] && x <= high[0] && y >= low[1] && y <= high[1] && dx * dx + dy * dy <= reach * reach;
    }
    double birth() const { return detection * undetected / (clutter + detection * undetected); }
};

// A part of a turn of an antenna: azimuths from north over east around the sensor's site.
struct Sector {
    double period = 0.0;     // seconds of a turn; 0: the whole turn is one scan
    double from = 0.0, to = 0.0, part = 1.0;  // part: share of the turn
    bool last = true;        // of its turn

    bool whole() const { return period <= 0.0; }
    bool holds(double dx, double dy) const {
        if (whole()) return true;
        const double azimuth = std::atan2(dx, dy), turned = azimuth < 0.0 ? azimuth + 6.283185307179586477 : azimuth;
        return turned >= from && turned < to;
    }
};

struct ManyRules {
    Association association = Association::marginal;
    double gate = 16.0, split_gate = 6.0;      // squared distances
    double confirm = 0.8, keep = 0.4;          // existence at which a track is confirmed, and below which no more
    double drop = 0.1;                         // existence relative to a birth's
    double life = 1e9;                         // mean seconds that a target stays
    double drop_after = 1e9;                   // seconds without a plot
    double unclaimed = 0.02;                   // probability that a plot is no track's from which it begins one
    double leave = 60.0;                       // mean seconds that a track is kept where no sensor looks
    double established = 0.5;                  // existence from which a track owns its plots
    double left = 0.0;                         // share of a plot's marginal that stays with a track where another owns it
    double abreast = INFINITY;                 // squared distance of velocities from which tracks do not own plots against each other
    double merge_within = 1.0;                 // squared distance below which two tracks may follow one target
    int merge_after = 5;                       // scans in a row after which the younger one ends; 0: never
    double inherit = 2.0;                      // a branch takes its parent's id if its score is higher by so much; infinite: never
    bool split = true;
    double patience = 0.1;                     // existence from which a track without a second plot in its second scan goes on
    int young = 2, crowd = 8;                  // scans and plots: older, with r < 0.5 and more plots in the gate, a track is dropped
    double sure = 0.95;                        // existence before a scan from which its plot or miss tells of the detection probability
    int most_plots = 64, most_tracks = 200000;
    bool likelihood = false;                   // report that of each scan
    int threads = 1;
};

// What a scan came to.
struct ScanReport {
    int plots = 0, unusable = 0, born = 0, dropped = 0, merged = 0, living = 0, confirmed = 0;
    int sure = 0, seen = 0;  // tracks that were surely there before the scan looked where they are, and those of them that had a plot
    bool crowded = false, full = false, inexact = false;  // gates with too many plots; no room for more tracks; JPDA by beliefs
    double log_likelihood = NAN;                          // of the scan's plots given those before
    std::vector<std::pair<std::int64_t, std::int64_t>> handed;  // tracks that go on under another id: the new one and the old one
};

// The confirmed track whose next plot a plot most probably is: its score before it, and what the plot would add.
struct Parent {
    std::int64_t id = -1;
    double score = 0.0, gain = -INFINITY;
};

// Where an established track is, and how surely: for merging.
struct Place {
    double x, y, xx, xy, yy;
    int slot;
};

class Many {
  public:
    Many(std::shared_ptr<const Composition<Pack>> composition, const ManyRules &rules, const std::vector<SensorView> &sensors)
        : c(std::move(composition)), rules(rules), sensors(sensors), pool(*c) {
        for (int t = 0; t < std::max(rules.threads, 1); ++t) scanners.push_back(std::make_unique<Scanner>(*c));
    }
    Many(const Many &) = delete;

    const std::shared_ptr<const Composition<Pack>> c;
    ManyRules rules;
    std::vector<SensorView> sensors;
    Pool pool;
    double time = NAN;
    std::int64_t next_id = 0;
    std::vector<double> lone;      // of each row of the last scan: probability that it is no track's; NaN if unusable

    ScanReport scan(double t, int sensor, const PlotRows &rows, const Sector &sector = Sector());

    // A target that is known to be there, in the reported components.
    std::int64_t add(double t, const double *x, const double *P, double existence);

    // Which plots each of these slots has taken in the last scan: rows of the scan and weights; the rest of a weight of one is "no plot".
    std::vector<Share> taken(int slot) const;

    std::vector<double> save() const;
    void restore(const std::vector<double> &state);

  private:
    std::vector<std::unique_ptr<Scanner>> scanners;
    Plots plots;
    Weighing weighing;
    Decide decide;
    std::vector<std::vector<Candidate>> candidates;  // of each slot
    std::vector<std::vector<Share>> shares;
    std::vector<char> crowded;
    std::vector<TrackState<Pack>> before;            // of each pack, where a scan is a sector
    int dropped = 0;
    Sector sector;
    std::vector<Parent> parents;                     // of each plot
    std::vector<Place> places;                       // of the established tracks
    std::vector<std::pair<std::int64_t, int>> found; // of each slot: an older track beside it, and for how many scans

    void measure(const PlotRows &rows, int sensor, ScanReport &report);
    void predict(double t, int sensor);
    Speed speed_of(int slot) const;
    void weigh(int sensor);
    void split(int sensor);
    double evidence(int slot, double unseen, double hit) const;
    void share_out(int slot);
    bool idle(int slot) const;
    bool looked_at(int slot, int sensor) const;
    void leave(const std::vector<int> &idle);
    void bear(double t, int sensor, ScanReport &report);
    void learn(double dt, int sensor);
    double log_likelihood(int sensor) const;
    bool outside(int slot) const;
    void judge(double t, int sensor, ScanReport &report);
    void place(int slot);
    void merge(ScanReport &report);
    void inherit(const std::vector<int> &heirs, ScanReport &report);
    template <class F> void over_packs(F work);
};

}  // namespace jink::inline JINK_LEVEL
