using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using OpenRoIS;

public static class StrandTests
{
    public static async Task WorkRunsInOrderAndNeverTwiceAtATime()
    {
        var strand = new Strand();
        var done = new List<int>();
        int running = 0, most = 0;
        var posters = Enumerable.Range(0, 4).Select(poster => Task.Run(() =>
        {
            for (int number = 0; number < 500; number++)
            {
                int mine = 1000 * poster + number;
                strand.Post(() =>
                {
                    most = Math.Max(most, Interlocked.Increment(ref running));
                    done.Add(mine);
                    Interlocked.Decrement(ref running);
                });
            }
        }));
        await Task.WhenAll(posters);
        await strand.Run(() => Task.FromResult(true));
        Check.Equal(1, most);
        for (int poster = 0; poster < 4; poster++)
        {
            Check.Equal(Enumerable.Range(1000 * poster, 500), done.Where(each => each / 1000 == poster));
        }
    }

    public static async Task AnAwaitComesBackToTheStrand()
    {
        var strand = new Strand();
        SynchronizationContext inside = await strand.Run(async () =>
        {
            await Task.Run(() => { });
            return SynchronizationContext.Current;
        });
        Check.True(inside == strand, "it is the strand");
        Check.True(SynchronizationContext.Current != strand, "the caller is not in it");
    }

    public static async Task WhatWorkThrowsIsTheCallers()
    {
        var strand = new Strand();
        await Check.ThrowsAsync<FormatException>(() => strand.Run(() => { throw new FormatException(); }));
        await Check.ThrowsAsync<OperationCanceledException>(
            () => strand.Run<int>(() => { throw new OperationCanceledException(); }));
    }

    public static async Task WhatPostedWorkThrowsIsTold()
    {
        var told = new TaskCompletionSource<Exception>();
        var strand = new Strand(null, error => told.TrySetResult(error));
        strand.Post(() => { throw new FormatException("oh"); });
        Check.Equal("oh", (await told.Task).Message);
        Check.Equal(1, await strand.Run(() => Task.FromResult(1)));
        Check.Throws<NotSupportedException>(() => strand.Send(_ => { }, null));
    }
}

public static class DispatcherTests
{
    public static void APumpRunsWhatWaitsAndNoMore()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var done = new List<string>();
        dispatcher.Post(_ =>
        {
            done.Add("first");
            dispatcher.Post(__ => done.Add("later"), null);
        }, null);
        dispatcher.Post(_ => done.Add("second"), null);
        Check.Equal(2, dispatcher.Pump());
        Check.Equal(new[] { "first", "second" }, done);
        Check.Equal(1, dispatcher.Waiting);
        Check.Equal(1, dispatcher.Pump());
        Check.Equal(0, dispatcher.Pump());
        Check.Equal("later", done[2]);
    }

    public static void AFrameCanHaveALimit()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        int done = 0;
        for (int number = 0; number < 5; number++)
        {
            dispatcher.Post(_ => done++, null);
        }
        Check.Equal(2, dispatcher.Pump(2));
        Check.Equal(2, done);
        Check.Equal(3, dispatcher.Pump());
    }

    public static void OneThatFailsDoesNotHoldUpTheOthers()
    {
        var failures = new List<string>();
        var dispatcher = new Dispatcher(error => failures.Add(error.Message));
        bool done = false;
        dispatcher.Post(_ => { throw new FormatException("oh"); }, null);
        dispatcher.Post(_ => done = true, null);
        dispatcher.Pump();
        Check.Equal(new[] { "oh" }, failures);
        Check.True(done, "the second was run");
        Check.Throws<ArgumentNullException>(() => new Dispatcher(null));
    }

    public static async Task AwaitsInACallbackComeBackToTheThread()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var threads = new List<int>();
        dispatcher.Post(async _ =>
        {
            threads.Add(Thread.CurrentThread.ManagedThreadId);
            await Task.Run(() => { });
            threads.Add(Thread.CurrentThread.ManagedThreadId);
        }, null);
        await Task.Run(() =>
        {
            while (threads.Count < 2)
            {
                dispatcher.Pump();
                Thread.Yield();
            }
            Check.Equal(Enumerable.Repeat(Thread.CurrentThread.ManagedThreadId, 2), threads);
            bool sent = false;
            dispatcher.Send(__ => sent = true, null);
            Check.True(sent, "the thread that pumps may send");
        });
        await Task.Factory.StartNew(
            () => Check.Throws<NotSupportedException>(() => dispatcher.Send(_ => { }, null)),
            TaskCreationOptions.LongRunning);
    }
}

public static class FeedTests
{
    public static async Task TheOldestMakesRoomAndIsCounted()
    {
        var feed = new Feed<int>(3);
        for (int number = 0; number < 5; number++)
        {
            feed.Offer(number);
        }
        feed.End();
        feed.Offer(5);
        var read = new List<int>();
        while (await feed.MoveNextAsync())
        {
            read.Add(feed.Current);
        }
        Check.Equal(new[] { 2, 3, 4 }, read);
        Check.Equal(2, feed.Dropped);
        Check.Throws<ArgumentOutOfRangeException>(() => new Feed<int>(0));
    }

    public static async Task AReaderWaitsUntilThereIsSomethingOrAnEnd()
    {
        var feed = new Feed<string>(3);
        Task<bool> waiting = feed.MoveNextAsync();
        Check.True(!waiting.IsCompleted, "it waits");
        feed.Offer("one");
        Check.True(await waiting, "there is one");
        Check.Equal("one", feed.Current);
        using (var soon = new CancellationTokenSource())
        {
            waiting = feed.MoveNextAsync(soon.Token);
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => waiting);
        }
        feed.End(new ConnectionLostException("gone"));
        await Check.ThrowsAsync<ConnectionLostException>(() => feed.MoveNextAsync());
    }

    public static void CallbacksTakeOnePlaceAndEndInTheMiddle()
    {
        var dispatcher = new Dispatcher(error => { throw error; });
        var taken = new List<int>();
        Callbacks<int> callbacks = null;
        callbacks = new Callbacks<int>(
            dispatcher,
            number =>
            {
                taken.Add(number);
                if (number == 2)
                {
                    callbacks.End();
                }
            },
            error => { throw error; },
            10);
        for (int number = 0; number < 5; number++)
        {
            callbacks.Offer(number);
        }
        Check.Equal(1, dispatcher.Waiting);
        dispatcher.Pump();
        callbacks.Offer(5);
        dispatcher.Pump();
        Check.Equal(new[] { 0, 1, 2 }, taken);
    }
}

public static class TimingTests
{
    public static void APumpedClockRingsWhatIsDueInOrder()
    {
        long now = 0;
        var timing = new PumpedTiming(() => now);
        var rung = new List<string>();
        timing.After(20, () => rung.Add("late"));
        timing.After(10, () => rung.Add("early"));
        IDisposable never = timing.After(5, () => rung.Add("never"));
        never.Dispose();
        timing.Pump();
        Check.Equal(0, rung.Count);
        now = 30;
        timing.Pump();
        timing.Pump();
        Check.Equal(new[] { "early", "late" }, rung);
        Check.Equal(30L, timing.Milliseconds);
    }

    public static async Task ADelayEndsWithTheClockOrItsToken()
    {
        var clock = new StandingClock();
        Task delay = clock.DelayAsync(100, CancellationToken.None);
        clock.Advance(99);
        Check.True(!delay.IsCompleted, "it waits");
        clock.Advance(1);
        await delay;
        using (var soon = new CancellationTokenSource())
        {
            delay = clock.DelayAsync(100, soon.Token);
            soon.Cancel();
            await Check.ThrowsAsync<OperationCanceledException>(() => delay);
            await Check.ThrowsAsync<OperationCanceledException>(() => clock.DelayAsync(1, soon.Token));
        }
        Check.Equal(0, clock.Alarms);
        await SystemTiming.Instance.DelayAsync(1, CancellationToken.None);
    }

    public static void WaitsGrowUpToALimitByChance()
    {
        var reconnect = new Reconnect { First = TimeSpan.FromMilliseconds(100), Limit = TimeSpan.FromMilliseconds(400), Factor = 2 };
        var longest = new long[4];
        for (int times = 0; times < 300; times++)
        {
            Backoff backoff = reconnect.Begin();
            for (int attempt = 0; attempt < longest.Length; attempt++)
            {
                longest[attempt] = Math.Max(longest[attempt], backoff.After(0));
            }
            Check.True(backoff.After(10000) < 100, "they begin anew after an attempt that lasted");
        }
        var limits = new[] { 100, 200, 400, 400 };
        for (int attempt = 0; attempt < limits.Length; attempt++)
        {
            Check.True(longest[attempt] < limits[attempt], "they stay below");
            Check.True(longest[attempt] > limits[attempt] * 0.8, "they are anything up to there");
        }
        Check.Equal(2500L, Reconnect.AskedToWait("retry_after=2.5"));
        Check.Equal(0L, Reconnect.AskedToWait("retry_after=-1"));
        Check.Equal(0L, Reconnect.AskedToWait(null));
    }
}
