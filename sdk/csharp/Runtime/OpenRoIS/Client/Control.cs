// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Asks for components that other applications hold, hands them over, and stops everything. Operations throw as those
    /// of <see cref="Operations"/>; a gateway without leases does not know them.
    /// </summary>
    public sealed class Control
    {
        private readonly Application _application;

        internal Control(Application application)
        {
            _application = application;
        }

        private Connection Connection
        {
            get { return _application.Connection; }
        }

        /// <summary>
        /// Returns the lease of a component; from then on <see cref="ClientNotices.ControlChanged"/> reports changes.
        /// </summary>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public Task<LeaseStatus> StatusAsync(string componentRef, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run(() => LeaseOf(componentRef, token));
        }

        /// <summary>Requests a component of its holder, and returns once it is bound; a free one is bound at once.</summary>
        /// <param name="componentRef">the component</param>
        /// <param name="wait">stays in line when the holder says no, until it is given back</param>
        /// <param name="token">gives up, and leaves the line</param>
        /// <exception cref="OutOfResourcesException">the holder said no, or nothing in time; or too many wait</exception>
        /// <exception cref="UnsupportedException">there is no such component, or not any more</exception>
        public Task RequestAsync(
            string componentRef, bool wait = false, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run(() => Request(componentRef, wait, token));
        }

        /// <summary>Hands a component over to the application that requests it; what runs ends with ABORT.</summary>
        /// <exception cref="UnsupportedException">there is no such request, or not any more</exception>
        public Task GrantAsync(string requestId, CancellationToken token = default(CancellationToken))
        {
            var given = new LeaseRequestParams { RequestId = requestId };
            return _application.Strand.Run(() => Connection.ActAsync(Methods.LeaseGrant, given, token));
        }

        /// <summary>Keeps a component that another application requests.</summary>
        /// <exception cref="UnsupportedException">there is no such request, or not any more</exception>
        public Task DeclineAsync(string requestId, CancellationToken token = default(CancellationToken))
        {
            var given = new LeaseRequestParams { RequestId = requestId };
            return _application.Strand.Run(() => Connection.ActAsync(Methods.LeaseDecline, given, token));
        }

        /// <summary>Binds a component as an administrator, also one that another application holds.</summary>
        /// <exception cref="UnsupportedException">there is none, or this application is no administrator</exception>
        public Task TakeAsync(string componentRef, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run(() => Connection.ActAsync(
                Methods.LeaseTake,
                new LeaseParams { ComponentRef = componentRef },
                token,
                taken => _application.Bindings.Use(componentRef)));
        }

        /// <summary>
        /// Takes a component with its part for a time from an application of lower rank, which has it back afterwards; what
        /// runs there ends with ABORT. A free component is simply bound. Borrow it again to have it for longer, and give it
        /// back as soon as it is not needed.
        /// </summary>
        /// <param name="componentRef">the component</param>
        /// <param name="time">for which it is taken; null for what the gateway is configured for (30 s)</param>
        /// <param name="forOneCommand">gives it back by itself when the next <c>start</c> has ended</param>
        /// <param name="token">gives up</param>
        /// <returns>the lease now</returns>
        /// <exception cref="OutOfResourcesException">its holder is not of lower rank: request it instead</exception>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public Task<LeaseStatus> BorrowAsync(
            string componentRef,
            TimeSpan? time = null,
            bool forOneCommand = false,
            CancellationToken token = default(CancellationToken))
        {
            var given = new LeaseBorrowParams
            {
                ComponentRef = componentRef,
                DurationMs = time == null ? null : (int?)Math.Round(time.Value.TotalMilliseconds),
                EndsWith = forOneCommand ? LoanEnd.Command : LoanEnd.Time
            };
            return _application.Strand.Run<LeaseStatus>(async () =>
            {
                LeaseResult answer = await Connection.ActAsync(
                    Methods.LeaseBorrow,
                    given,
                    token,
                    accepted => _application.Bindings.Use(componentRef),
                    late => ReleaseUnwanted(componentRef));
                return answer.Lease ?? new LeaseStatus();
            });
        }

        /// <summary>
        /// Releases all of the part of a component: an application from which it was taken for a time has it back.
        /// </summary>
        /// <exception cref="UnsupportedException">there is no such component</exception>
        public Task GiveBackAsync(string componentRef, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run(() => Connection.ActAsync(
                Methods.LeaseGiveBack,
                new LeaseParams { ComponentRef = componentRef },
                token,
                done => _application.Bindings.GaveBack(componentRef)));
        }

        /// <summary>
        /// Stops everything that acts on an engine, and returns which components have stopped. Where this application
        /// is a person's, programs wait then until a person hands back. It is no safety-rated emergency stop.
        /// </summary>
        /// <param name="engineId">the engine; null for every one of which this application holds something</param>
        /// <param name="token">ends the wait</param>
        /// <exception cref="ComponentFailedException">something did not say that it has stopped</exception>
        /// <exception cref="UnsupportedException">nothing that acts there is in scope</exception>
        public Task<IReadOnlyList<string>> StopAllAsync(
            string engineId = null, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run<IReadOnlyList<string>>(async () =>
            {
                var given = new StopAllParams { EngineId = engineId };
                return (await Connection.ActAsync(Methods.StopAll, given, token)).Stopped;
            });
        }

        /// <summary>
        /// Hands a body that a person has stopped back to programs, as a person. It ends the STOP that this client was told
        /// last, and no later one; where it was told none, whichever holds.
        /// </summary>
        /// <exception cref="OutOfResourcesException">it was stopped again meanwhile: hand it back anew</exception>
        /// <exception cref="UnsupportedException">this application is a program, or nothing there is in scope</exception>
        public Task ReleaseStopAsync(string engineId, CancellationToken token = default(CancellationToken))
        {
            return _application.Strand.Run(() =>
            {
                string stopId = _application.Notices.TakeStop(engineId);
                var given = new ReleaseStopParams { EngineId = engineId, StopId = stopId };
                return Connection.ActAsync(Methods.LeaseReleaseStop, given, token);
            });
        }

        private async Task<LeaseStatus> LeaseOf(string componentRef, CancellationToken token)
        {
            var given = new LeaseParams { ComponentRef = componentRef };
            LeaseResult result = await Connection.AskAsync(Methods.LeaseQuery, given, token);
            LeaseStatus lease = result.Lease ?? new LeaseStatus();
            _application.Notices.NoteStop(componentRef.Split('/')[0], lease.StopId);
            return lease;
        }

        private async Task Request(string componentRef, bool wait, CancellationToken token)
        {
            var granted = new TaskCompletionSource<bool>(TaskCreationOptions.RunContinuationsAsynchronously);
            string requestId = "";
            Action<LeaseChangedNotification> changed = told =>
            {
                if (told.ComponentRef == componentRef && told.State == LeaseState.Mine)
                {
                    granted.TrySetResult(true);
                }
            };
            Action<LeaseDeclinedNotification> doubtful = told =>
            {
                if (told != null && !wait && told.RequestId == requestId)
                {
                    string said = componentRef + ": " + told.Reason;
                    granted.TrySetException(new OutOfResourcesException(said, told.Reason));
                }
                else
                {
                    // It may be gone, also for a moment, or not be shown to this application any more.
                    RequirePlace(componentRef, granted).LetRun();
                }
            };
            Action<string, bool> ended = (reason, forGood) => granted.TrySetException(
                new ConnectionLostException("openrois.lease.request: " + reason));
            _application.OnLeaseChanged += changed;
            _application.OnLeaseDoubtful += doubtful;
            _application.OnConnectionEnded += ended;
            try
            {
                var given = new LeaseParams { ComponentRef = componentRef };
                LeaseRequestResult answer = await Connection.ActAsync(
                    Methods.LeaseRequest, given, token, accepted => requestId = accepted.RequestId,
                    late => GiveUp(componentRef));
                if (answer.Lease == null || answer.Lease.State != LeaseState.Mine)
                {
                    await WaitFor(granted.Task, componentRef, token);
                }
                _application.Bindings.Use(componentRef);
            }
            finally
            {
                _application.OnLeaseChanged -= changed;
                _application.OnLeaseDoubtful -= doubtful;
                _application.OnConnectionEnded -= ended;
            }
        }

        private async Task WaitFor(Task<bool> granted, string componentRef, CancellationToken token)
        {
            try
            {
                await granted.OrCanceled(token);
            }
            catch (Exception)
            {
                GiveUp(componentRef);
                throw;
            }
        }

        private async Task RequirePlace(string componentRef, TaskCompletionSource<bool> granted)
        {
            try
            {
                LeaseStatus lease = await LeaseOf(componentRef, CancellationToken.None);
                if (lease.State != LeaseState.Mine && lease.Position == 0)
                {
                    granted.TrySetException(new OutOfResourcesException(
                        componentRef + ": the request for it was dropped: request it again"));
                }
            }
            catch (Exception error)
            {
                granted.TrySetException(error);
            }
        }

        /// <summary>Leaves the line for a component, which may have become ours in the same moment.</summary>
        private void GiveUp(string componentRef)
        {
            Connection.Post(Methods.LeaseLeave, new LeaseParams { ComponentRef = componentRef });
            ReleaseUnwanted(componentRef);
        }

        private void ReleaseUnwanted(string componentRef)
        {
            if (!_application.Bindings.Wants(componentRef))
            {
                Connection.Post(Methods.CommandRelease, new ComponentParams { ComponentRef = componentRef });
            }
        }
    }
}
