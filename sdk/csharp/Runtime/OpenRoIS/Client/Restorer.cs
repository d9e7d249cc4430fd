// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Keeps bindings and subscriptions at a gateway as the application wants them. What an engine that has changed was
    /// asked for is made again: it may have left and come back, and have forgotten it. What is missing is tried again after
    /// a while: RoIS has no notification that a component was given back, or works again.
    /// </summary>
    internal sealed class Restorer
    {
        private readonly Bindings _bindings;
        private readonly Subscriptions _subscriptions;
        private readonly ClientOptions _options;
        private TaskCompletionSource<bool> _changed = NewSignal();

        /// <summary>What has changed and was not dealt with yet; null for nothing.</summary>
        private ProfileChange _change;

        internal Restorer(Bindings bindings, Subscriptions subscriptions, ClientOptions options)
        {
            _bindings = bindings;
            _subscriptions = subscriptions;
            _options = options;
        }

        /// <summary>Notes that engines came, went, or are others now.</summary>
        internal void ProfileChanged(ProfileChange change)
        {
            _change = _change == null ? change : _change.With(change);
            _changed.TrySetResult(true);
        }

        /// <summary>Notes that something is to be bound again that did not have to be before.</summary>
        internal void BindMissing()
        {
            _changed.TrySetResult(true);
        }

        /// <summary>Works until the connection has ended; what was bound is bound again already.</summary>
        internal async Task RunAsync(JsonRpcSession session, long within, CancellationToken token)
        {
            Backoff backoff = _options.Reconnect.Begin();
            await _subscriptions.RenewAsync(session, within, null, token);
            while (true)
            {
                bool incomplete = _bindings.Incomplete || _subscriptions.Incomplete;
                bool changed = await ChangedWithinAsync(incomplete ? backoff.After(0) : -1, token);
                if (changed)
                {
                    backoff = _options.Reconnect.Begin();
                }
                ProfileChange change = _change;
                _change = null;
                await _bindings.RenewAsync(session, within, token);
                await _subscriptions.RenewAsync(session, within, change, token);
            }
        }

        /// <summary>Waits until the profile has changed, or for some time if that is not negative; tells which it was.</summary>
        private async Task<bool> ChangedWithinAsync(long milliseconds, CancellationToken token)
        {
            Task<bool> changed = _changed.Task;
            if (milliseconds < 0)
            {
                await changed.OrCanceled(token);
            }
            else
            {
                using (CancellationTokenSource either = CancellationTokenSource.CreateLinkedTokenSource(token))
                {
                    await Task.WhenAny(changed, _options.Timing.DelayAsync(Math.Max(milliseconds, 1), either.Token));
                    either.Cancel();
                    token.ThrowIfCancellationRequested();
                }
            }
            if (!changed.IsCompleted)
            {
                return false;
            }
            _changed = NewSignal();
            return true;
        }

        private static TaskCompletionSource<bool> NewSignal()
        {
            return new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
        }
    }
}
