// One thread puts, one takes, as fast as they can. Every value carries a number and a check of all its words, so a torn
// one shows even where the thread sanitizer is not there. Built with it (see CMakeLists.txt); exit status 66 is the
// sanitizer's.

#include <hfh/device/triple_buffer.hpp>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <thread>

namespace {

struct Value {
    std::uint64_t number = 0;
    std::uint64_t words[30]{};
    std::uint64_t check = 0;
};

std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58'476d'1ce4'e5b9u;
    x = (x ^ (x >> 27)) * 0x94d0'49bb'1331'11ebu;
    return x ^ (x >> 31);
}

Value make(std::uint64_t number) {
    Value value;
    value.number = number;
    value.check = number;
    for (std::uint64_t k = 0; auto& word : value.words) value.check += word = mixed(32 * number + ++k);
    return value;
}

bool is_whole(const Value& value) {
    std::uint64_t sum = value.number;
    for (std::uint64_t k = 0; const auto word : value.words) {
        if (value.number != 0 && word != mixed(32 * value.number + ++k)) return false;
        sum += word;
    }
    return value.check == sum;
}

#ifdef HFH_TEST_BROKEN
/// What a triple buffer is without its memory orders. Its exchanges are atomic all the same, but say nothing of the
/// values: the sanitizer has to find that out, or it would find nothing.
class Latest {
public:
    void put(const Value& value) noexcept {
        slots_[writers_] = value;
        writers_ = between_.exchange(writers_ | 4u, std::memory_order_relaxed) & 3u;
    }
    bool take(Value& value) noexcept {
        const bool is_new = (between_.load(std::memory_order_relaxed) & 4u) != 0;
        if (is_new) readers_ = between_.exchange(readers_, std::memory_order_relaxed) & 3u;
        value = slots_[readers_];
        return is_new;
    }

private:
    Value slots_[3]{};
    unsigned writers_ = 0, readers_ = 1;
    std::atomic<unsigned> between_{2};
};
#else
using Latest = hfh::TripleBuffer<Value>;
#endif

} // namespace

int main() {
    constexpr std::uint64_t count = 200'000;
    static Latest latest;
    std::thread writer{[] {
        for (std::uint64_t n = 1; n <= count; ++n) {
            latest.put(make(n));
            if (n % 64 == 0) std::this_thread::yield(); // where there is but one core, take turns
        }
    }};
    std::uint64_t last = 0, fresh = 0, torn = 0, backwards = 0, wrong_news = 0;
    while (last < count) {
        Value value;
        const bool is_new = latest.take(value);
        torn += !is_whole(value);
        backwards += value.number < last;
        wrong_news += is_new != (value.number != last);
        fresh += is_new;
        last = value.number;
        if (!is_new) std::this_thread::yield();
    }
    writer.join();
    std::printf("%llu values put, %llu taken: %llu torn, %llu backwards, %llu wrongly told new or not\n",
                static_cast<unsigned long long>(count), static_cast<unsigned long long>(fresh),
                static_cast<unsigned long long>(torn), static_cast<unsigned long long>(backwards),
                static_cast<unsigned long long>(wrong_news));
    return torn + backwards + wrong_news == 0 && fresh > 10 ? 0 : 1;
}
