// Copyright the OpenRoIS authors. Apache-2.0.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Reflection;
using System.Runtime.Serialization;
using Newtonsoft.Json;
using Newtonsoft.Json.Linq;
using Newtonsoft.Json.Serialization;

namespace OpenRoIS
{
    /// <summary>What every method gives.</summary>
    public interface IOutcome
    {
        /// <summary>How the operation ended; otherwise than OK all else is empty.</summary>
        ReturnCode ReturnCode { get; }
    }

    /// <summary>A method of the wire, with the types of what it takes and gives.</summary>
    public sealed class Method<TParams, TResult>
    {
        public Method(string name)
        {
            Name = name;
        }

        public string Name { get; private set; }
    }

    /// <summary>A notification of the wire, with the type of what it carries.</summary>
    public sealed class Notification<TParams>
    {
        public Notification(string name)
        {
            Name = name;
        }

        public string Name { get; private set; }
    }

    /// <summary>
    /// Reads and writes messages as strictly as the wire: nothing missing, nothing unknown, nothing converted. Limits
    /// on numbers and lengths are left to the engine, which checks them.
    /// </summary>
    public static class RoISJson
    {
        /// <summary>The settings that make it so, for use with a serializer of one's own.</summary>
        public static JsonSerializerSettings CreateSettings()
        {
            JsonSerializerSettings settings = new JsonSerializerSettings
            {
                CheckAdditionalContent = true,
                ContractResolver = Resolver,
                Converters =
                {
                    new TextConverter(), new IntegerConverter(), new NameConverter(), new ListConverter(),
                    new MapConverter()
                },
                DateParseHandling = DateParseHandling.None,
                MissingMemberHandling = MissingMemberHandling.Error,
                ObjectCreationHandling = ObjectCreationHandling.Replace
            };
            foreach (JsonConverter converter in Unions.Converters)
            {
                settings.Converters.Add(converter);
            }
            return settings;
        }

        /// <exception cref="JsonException">The text is not JSON, or not a message of this type.</exception>
        public static T Read<T>(string json)
        {
            return (T)Read(json, typeof(T));
        }

        /// <exception cref="JsonException">The text is not JSON, or not a message of this type.</exception>
        public static object Read(string json, Type type)
        {
            object read = JsonConvert.DeserializeObject(json, type, CreateSettings());
            if (read == null)
            {
                throw new JsonSerializationException("null is no " + type.Name);
            }
            return read;
        }

        /// <exception cref="JsonException">Something required is null.</exception>
        public static string Write(object message)
        {
            return JsonConvert.SerializeObject(message, CreateSettings());
        }

        /// <summary>Reads what came of a message, and passes over members that this version does not know.</summary>
        /// <exception cref="JsonException">It is no message of this type.</exception>
        internal static T Known<T>(JToken message)
            where T : class
        {
            JsonSerializerSettings settings = CreateSettings();
            settings.MissingMemberHandling = MissingMemberHandling.Ignore;
            settings.CheckAdditionalContent = false;
            T read = message.ToObject<T>(JsonSerializer.Create(settings));
            if (read == null)
            {
                throw new JsonSerializationException("null is no " + typeof(T).Name);
            }
            return read;
        }

        /// <summary>Writes a message for the inside of another one.</summary>
        /// <exception cref="JsonException">Something required is null.</exception>
        internal static JObject ToObject(object message)
        {
            return JObject.FromObject(message, JsonSerializer.Create(CreateSettings()));
        }

        /// <summary>The name of an enumerator on the wire.</summary>
        internal static string NameOf(object member)
        {
            FieldInfo field = member.GetType().GetField(member.ToString());
            return ((EnumMemberAttribute)Attribute.GetCustomAttribute(field, typeof(EnumMemberAttribute))).Value;
        }

        // Contracts are cached by the resolver; one per call would reflect on every message anew.
        private static readonly OmittingResolver Resolver = new OmittingResolver();
    }

    /// <summary>What need not stand is not written when it is null: on the wire it would be wrong.</summary>
    internal sealed class OmittingResolver : DefaultContractResolver
    {
        protected override JsonProperty CreateProperty(MemberInfo member, MemberSerialization serialization)
        {
            JsonProperty property = base.CreateProperty(member, serialization);
            if (property.Required == Required.Default)
            {
                IValueProvider values = property.ValueProvider;
                property.ShouldSerialize = target => values.GetValue(target) != null;
            }
            return property;
        }
    }

    /// <summary>A converter for reading alone; what is written is written as usual.</summary>
    public abstract class ReadingConverter : JsonConverter
    {
        public override bool CanWrite
        {
            get { return false; }
        }

        public override void WriteJson(JsonWriter writer, object value, JsonSerializer serializer)
        {
            throw new NotSupportedException();
        }

        protected static void Expect(JsonReader reader, JsonToken token)
        {
            if (reader.TokenType != token)
            {
                throw new JsonSerializationException(reader.Path + ": " + token + " expected, not " + reader.TokenType);
            }
        }
    }

    internal sealed class TextConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type == typeof(string);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            Expect(reader, JsonToken.String);
            return reader.Value;
        }
    }

    internal sealed class TextOrNullConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type == typeof(string);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            if (reader.TokenType != JsonToken.Null)
            {
                Expect(reader, JsonToken.String);
            }
            return reader.Value;
        }
    }

    /// <summary>What names a request of JSON-RPC: text or a number.</summary>
    internal sealed class IdentityConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type == typeof(object);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            if (reader.TokenType != JsonToken.Null && reader.TokenType != JsonToken.Integer
                && reader.TokenType != JsonToken.Float)
            {
                Expect(reader, JsonToken.String);
            }
            return reader.Value;
        }
    }

    internal sealed class IntegerConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            Type plain = Nullable.GetUnderlyingType(type) ?? type;
            return plain == typeof(int) || plain == typeof(long);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            Expect(reader, JsonToken.Integer);
            try
            {
                return Convert.ChangeType(reader.Value, Nullable.GetUnderlyingType(type) ?? type);
            }
            catch (Exception error)
            {
                // An integer of more than 64 bits comes as a type of its own, which does not convert.
                throw new JsonSerializationException(reader.Path + ": the number is too great", error);
            }
        }
    }

    /// <summary>Enumerations by the names that they have on the wire, in the letters that they have there.</summary>
    internal sealed class NameConverter : JsonConverter
    {
        public override bool CanConvert(Type type)
        {
            return (Nullable.GetUnderlyingType(type) ?? type).IsEnum;
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            Type enumeration = Nullable.GetUnderlyingType(type) ?? type;
            foreach (object member in Enum.GetValues(enumeration))
            {
                if (reader.TokenType == JsonToken.String && RoISJson.NameOf(member) == (string)reader.Value)
                {
                    return member;
                }
            }
            throw new JsonSerializationException(reader.Path + ": " + reader.Value + " is no " + enumeration.Name);
        }

        public override void WriteJson(JsonWriter writer, object value, JsonSerializer serializer)
        {
            writer.WriteValue(RoISJson.NameOf(value));
        }
    }

    /// <summary>Lists, of which no item is null.</summary>
    internal sealed class ListConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type.IsGenericType && type.GetGenericTypeDefinition() == typeof(List<>);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            Expect(reader, JsonToken.StartArray);
            IList items = (IList)Activator.CreateInstance(type);
            Type itemType = type.GetGenericArguments()[0];
            while (reader.Read() && reader.TokenType != JsonToken.EndArray)
            {
                if (reader.TokenType == JsonToken.Null)
                {
                    throw new JsonSerializationException(reader.Path + " is null");
                }
                items.Add(serializer.Deserialize(reader, itemType));
            }
            return items;
        }
    }

    /// <summary>Objects with keys of any name, of which no value is null.</summary>
    internal sealed class MapConverter : ReadingConverter
    {
        public override bool CanConvert(Type type)
        {
            return type.IsGenericType && type.GetGenericTypeDefinition() == typeof(Dictionary<,>);
        }

        public override object ReadJson(JsonReader reader, Type type, object existing, JsonSerializer serializer)
        {
            Expect(reader, JsonToken.StartObject);
            IDictionary values = (IDictionary)Activator.CreateInstance(type);
            Type valueType = type.GetGenericArguments()[1];
            while (reader.Read() && reader.TokenType == JsonToken.PropertyName)
            {
                string name = (string)reader.Value;
                reader.Read();
                if (reader.TokenType == JsonToken.Null)
                {
                    throw new JsonSerializationException(reader.Path + " is null");
                }
                values[name] = serializer.Deserialize(reader, valueType);
            }
            return values;
        }
    }
}
