// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;

namespace OpenRoIS
{
    /// <summary>
    /// Lists and reserves the bodies of one client, and gives a body back when a part of it is lost.
    ///
    /// Components are bound in the sorted order of their references. Of applications that try at the same moment one always
    /// gets its body, unless an application that has its body holds a part of it. The others release what they have and try
    /// again after a while, by chance. Nothing is held while they wait. All of it runs in the client's strand.
    /// </summary>
    internal sealed class Bodies
    {
        private const long First = 100;
        private const long Longest = 1000;
        private const double Factor = 1.5;
        private const int AtOnce = 64;
        private const int Unread = -1;

        private readonly Random _chance = new Random();
        private readonly Dictionary<string, Reservation> _reserved = new Dictionary<string, Reservation>();
        private readonly Client _client;
        private readonly Application _application;
        private readonly ITiming _timing;

        internal Bodies(Client client, Application application, ITiming timing)
        {
            _client = client;
            _application = application;
            _timing = timing;
            application.OnBindingLost += loss => Lose(loss.ComponentRef, loss.Error);
            application.OnConnectionEnded += ConnectionEnded;
        }

        private Bindings Bindings
        {
            get { return _application.Bindings; }
        }

        internal async Task<IReadOnlyList<BodyInfo>> AllAsync(CancellationToken token)
        {
            List<BodyProfile> bodies = await ReadAsync("", token);
            Dictionary<string, bool?> free = await FreeAsync(bodies, token);
            return bodies.Select(body => new BodyInfo(
                body.EngineId,
                body.Types.Select(each => new BodyComponent(each.Key, each.Value, free[each.Key])).ToList())).ToList();
        }

        internal async Task<Body> ReserveAsync(BodyRequest request, CancellationToken token)
        {
            long deadline = _timing.Milliseconds + (long)request.Wait.TotalMilliseconds;
            var backoff = new Backoff(First, Factor, Longest, _chance);
            var bodies = new List<BodyProfile>();
            int readIn = Unread;
            while (true)
            {
                if (readIn != _application.Generation)
                {
                    readIn = _application.Generation;
                    bodies = await ReadAsync(request.Condition, token);
                }
                var refusals = new List<KeyValuePair<string, RoISException>>();
                foreach (BodyProfile body in Candidates(bodies, request))
                {
                    try
                    {
                        return await TryAsync(body, request, token);
                    }
                    catch (RoISException refusal)
                    {
                        refusals.Add(new KeyValuePair<string, RoISException>(body.EngineId, refusal));
                    }
                }
                if (refusals.Count == 0 || refusals.Any(each => each.Value is UnsupportedException))
                {
                    // Not every gateway notifies that components came or went.
                    readIn = Unread;
                }
                long left = deadline - _timing.Milliseconds;
                if (left <= 0)
                {
                    throw Failure(request, bodies, refusals);
                }
                await _timing.DelayAsync(Math.Max(Math.Min(backoff.After(0), left), 1), token);
            }
        }

        /// <summary>Releases all components at once, and returns when that was done. Callable from any thread.</summary>
        internal Task ReleaseAsync(Reservation reservation)
        {
            return _application.Strand.Run(async () =>
            {
                IReadOnlyList<string> refs = GiveBack(reservation);
                if (refs.Count == 0)
                {
                    return;
                }
                try
                {
                    // Behind the releases: its answer says that they were done.
                    var behind = new ConditionParams { Condition = Condition.ComponentRef(refs[0]) };
                    await _application.Connection.ActAsync(Methods.CommandSearch, behind, CancellationToken.None);
                }
                catch (Exception)
                {
                    // With the connection the bindings end.
                }
            });
        }

        /// <summary>All bodies, or those with components that meet a condition.</summary>
        private async Task<List<BodyProfile>> ReadAsync(string condition, CancellationToken token)
        {
            if (condition == "" && _application.Extensions.Contains(EngineDirectory.Extension))
            {
                return BodyDirectory.Read(await _application.Directory.ReadAsync(token));
            }
            var given = new ConditionParams { Condition = condition };
            return BodyDirectory.Read(await _application.Connection.AskAsync(Methods.SystemGetProfile, given, token));
        }

        /// <summary>Tells of each component whether no application holds it; null where the gateway does not tell.</summary>
        private async Task<Dictionary<string, bool?>> FreeAsync(List<BodyProfile> bodies, CancellationToken token)
        {
            bool tells = _application.Extensions.Contains(Resumption.Extension);
            Dictionary<string, bool?> free = bodies.SelectMany(body => body.Types.Keys).Distinct()
                .ToDictionary(each => each, each => tells ? true : (bool?)null);
            List<string> leased = bodies.SelectMany(body => body.Leased).Distinct().ToList();
            for (int first = 0; tells && first < leased.Count; first += AtOnce)
            {
                await Task.WhenAll(leased.Skip(first).Take(AtOnce).Select(
                    async componentRef => free[componentRef] = await IsFreeAsync(componentRef, token)));
            }
            return free;
        }

        private async Task<bool?> IsFreeAsync(string componentRef, CancellationToken token)
        {
            try
            {
                return (await _client.Control.StatusAsync(componentRef, token)).State == LeaseState.Free;
            }
            catch (RoISException)
            {
                // It is gone meanwhile, or this application may not know.
                return null;
            }
        }

        /// <summary>Reserves one body, or nothing of it.</summary>
        /// <exception cref="RoISException">a required component is not to be had</exception>
        private async Task<Body> TryAsync(BodyProfile body, BodyRequest request, CancellationToken token)
        {
            var reservation = new Reservation(body.EngineId, request.Optional.Select(type => type.Urn));
            try
            {
                await BindEachAsync(reservation, body, request.Required, true, token);
                await BindEachAsync(reservation, body, request.Optional, false, token);
                reservation.RequireHeld();
            }
            catch (Exception)
            {
                GiveBack(reservation);
                throw;
            }
            reservation.Complete = true;
            var parts = new Dictionary<string, ComponentProxy>();
            foreach (ComponentType type in request.All.Where(type => reservation.Bound.ContainsKey(type.Urn)))
            {
                parts[type.Urn] = type.Make(_client, reservation.Bound[type.Urn]);
            }
            return new Body(reservation, parts, this);
        }

        /// <summary>Binds the first component of each type that is to be had, in the sorted order of all references.</summary>
        private async Task BindEachAsync(
            Reservation reservation,
            BodyProfile body,
            IEnumerable<ComponentType> types,
            bool required,
            CancellationToken token)
        {
            var urns = new HashSet<string>(types.Select(type => type.Urn));
            List<KeyValuePair<string, string>> found = body.Types.Where(each => urns.Contains(each.Value)).ToList();
            for (int place = 0; place < found.Count; place++)
            {
                string urn = found[place].Value;
                if (reservation.Bound.ContainsKey(urn))
                {
                    continue;
                }
                bool isLast = found.Skip(place + 1).All(other => other.Value != urn);
                try
                {
                    await BindAsync(reservation, found[place].Key, token);
                    reservation.Add(urn, found[place].Key);
                }
                catch (RoISException) when (!(required && isLast))
                {
                    // There is another one, or it need not be there.
                }
            }
        }

        private async Task BindAsync(Reservation reservation, string componentRef, CancellationToken token)
        {
            if (_reserved.ContainsKey(componentRef))
            {
                throw new OutOfResourcesException(componentRef + " is a part of another body of this application");
            }
            _reserved[componentRef] = reservation;
            try
            {
                await _client.Reserve(componentRef, token);
            }
            catch (Exception)
            {
                _reserved.Remove(componentRef);
                throw;
            }
            if (reservation.Error != null)
            {
                Release(componentRef);
                reservation.RequireHeld();
            }
        }

        /// <summary>Sends all releases at once; returns what was released.</summary>
        private IReadOnlyList<string> GiveBack(Reservation reservation)
        {
            IReadOnlyList<string> refs = reservation.TakeAll();
            foreach (string componentRef in refs)
            {
                Release(componentRef);
            }
            return refs;
        }

        private void Release(string componentRef)
        {
            _reserved.Remove(componentRef);
            if (!Bindings.Unuse(componentRef))
            {
                return;
            }
            Bindings.GaveBack(componentRef);
            // A task that binds it now would lose it to a release that is sent after its bind.
            if (!Bindings.IsInTurn(componentRef))
            {
                var given = new ComponentParams { ComponentRef = componentRef };
                _application.Connection.Post(Methods.CommandRelease, given);
            }
        }

        private void Lose(string componentRef, Exception error)
        {
            Reservation reservation;
            if (!_reserved.TryGetValue(componentRef, out reservation))
            {
                return;
            }
            string urn = reservation.Bound.FirstOrDefault(each => each.Value == componentRef).Key;
            if (urn != null && reservation.Optional.Contains(urn))
            {
                reservation.Remove(urn);
                Release(componentRef);
                return;
            }
            LoseAll(reservation, componentRef, error);
        }

        private void ConnectionEnded(string reason, bool forGood)
        {
            if (forGood)
            {
                foreach (Reservation reservation in _reserved.Values.Distinct().ToList())
                {
                    LoseAll(reservation, "", new ConnectionLostException(reason));
                }
            }
        }

        private void LoseAll(Reservation reservation, string componentRef, Exception error)
        {
            reservation.Error = error;
            GiveBack(reservation);
            if (reservation.Complete)
            {
                _client.Notify(new BodyLoss(reservation.EngineId, componentRef, error));
            }
        }

        /// <summary>The bodies with all that is required, those that have more of what is optional first.</summary>
        private static IEnumerable<BodyProfile> Candidates(IEnumerable<BodyProfile> bodies, BodyRequest request)
        {
            return bodies.Where(body => request.Required.All(type => body.Has(type.Urn)))
                .OrderByDescending(body => request.Optional.Count(type => body.Has(type.Urn)));
        }

        private static RoISException Failure(
            BodyRequest request, List<BodyProfile> bodies, List<KeyValuePair<string, RoISException>> refusals)
        {
            string named = "body with " + request + (request.Condition == "" ? "" : " where " + request.Condition);
            if (refusals.Count > 0)
            {
                return new OutOfResourcesException(
                    "no " + named + " is free: "
                    + string.Join("; ", refusals.Select(each => each.Key + ": " + each.Value.Message)));
            }
            string there = string.Join("; ", bodies.Select(body => body.EngineId + " (" + body.Codes + ")"));
            return new UnsupportedException("there is no " + named + "; there are: " + (there == "" ? "none" : there));
        }
    }
}
