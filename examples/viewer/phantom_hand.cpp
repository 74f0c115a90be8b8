#include "real_device.hpp"

#include <bad_input.hpp>
#include <numbers.hpp>
#include <openhaptics.hpp>
#include <phantom_device.hpp>
#include <reconnect.hpp>
#include <sentences.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace viewer {
namespace {

/// Runs the adapter of examples/phantom in a thread of its own.
class PhantomHand final : public RealDevice {
public:
    PhantomHand() {
        device_.emplace();
        if (!device_->is_open()) {
            char code[16];
            std::snprintf(code, sizeof code, "0x%04x", device_->report().last_error);
            throw demo::BadInput{std::string{"--device phantom: no device opens, the driver tells error "} +
                                 code + "."};
        }
        capabilities_ = device_->capabilities();
    }
    ~PhantomHand() override { PhantomHand::stop(); }
    PhantomHand(const PhantomHand&) = delete;
    PhantomHand& operator=(const PhantomHand&) = delete;

    [[nodiscard]] hfh::DeviceCapabilities capabilities() const override { return capabilities_; }

    void start(Tick tick) override {
        tick_ = std::move(tick);
        thread_ = std::thread{[this] {
            const auto wait = [] { std::this_thread::sleep_for(std::chrono::milliseconds{500}); };
            (void)phantom::run_and_reconnect([this] { return attempt(); }, wait,
                                             [this] { return !is_stopping(); });
        }};
    }

    void stop() override {
        {
            const std::lock_guard lock{mutex_};
            is_stopping_ = true;
            if (device_) device_->stop();
        }
        if (thread_.joinable()) thread_.join();
        device_.reset();
    }

    [[nodiscard]] std::string trouble() override {
        const std::lock_guard lock{mutex_};
        const char* const why = device_ ? phantom::sentence(device_->report()) : phantom::sentence(last_end_);
        return *why == '\0' ? "" : std::string{"Device: "} + why + ".";
    }

    [[nodiscard]] std::string report() const override {
        char text[200];
        std::snprintf(text, sizeof text,
                      "phantom         %s; %s updates, %s late (%.2f ms at most), longest tick %.3f ms\n",
                      phantom::sentence(last_end_), demo::grouped(sum_.updates).c_str(),
                      demo::grouped(sum_.late).c_str(), 1e3 * sum_.latest, 1e3 * sum_.longest_tick);
        return text;
    }

private:
    using Device = phantom::PhantomDevice<phantom::OpenHaptics>;

    [[nodiscard]] bool is_stopping() const {
        const std::lock_guard lock{mutex_};
        return is_stopping_;
    }

    /// One opening, if it is not the first one, and one run.
    hfh::DeviceEnd attempt() {
        {
            const std::lock_guard lock{mutex_};
            if (is_stopping_) return last_end_ = hfh::DeviceEnd::stopped;
            if (!device_) device_.emplace();
        }
        const hfh::DeviceEnd end =
            device_->run([this](const hfh::DeviceSample& sample) noexcept { return tick_(sample); });
        const std::lock_guard lock{mutex_};
        const phantom::Report report = device_->report();
        sum_.updates += report.updates;
        sum_.late += report.late;
        sum_.latest = std::max(sum_.latest, report.latest);
        sum_.longest_tick = std::max(sum_.longest_tick, report.longest_tick);
        device_.reset();
        return last_end_ = end;
    }

    hfh::DeviceCapabilities capabilities_{};
    Tick tick_;
    mutable std::mutex mutex_; ///< of all that follows; the driver's thread does not take it
    std::optional<Device> device_;
    bool is_stopping_ = false;
    hfh::DeviceEnd last_end_ = hfh::DeviceEnd::stopped;
    phantom::Report sum_{}; ///< of all runs
    std::thread thread_;
};

} // namespace

std::unique_ptr<RealDevice> open_phantom() { return std::make_unique<PhantomHand>(); }

} // namespace viewer
